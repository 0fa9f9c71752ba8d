"""The page of `fit-lra --report`, looked at in a real browser: it shows the constants that `--json`
gives with their budget, draws its figures, fetches nothing, fits a narrow screen and prints.
"""
import json
import os
import re
import shutil
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import browser  # noqa: E402
from programs import check, run  # noqa: E402

MOST_PAGES = 9


def main():
    with tempfile.TemporaryDirectory() as directory:
        opened = os.path.join(directory, "open <1> & on.csv")
        shutil.copy("fixtures/impulse.csv", opened)
        silent = os.path.join(directory, "silent.csv")
        with open(silent, "w", encoding="utf-8") as file:
            file.write("time_s,voltage_v\n")
            file.writelines(f"{k * 1e-4:.4f},0.25\n" for k in range(500))
        words = ["fit-lra", opened, "fixtures/impulse_33ohm.csv", silent, "--moving-mass", "1.40(3)g"]
        report = os.path.join(directory, "fit.html")
        done = run(*words, "--report", report, "--json", status=3)  # of one file nothing can be said
        answer = json.loads(done.stdout)
        check(os.path.getsize(report) < 3_000_000, "the page is no larger than 3 MB")

        with browser.page(report) as shown:
            text = shown.text()
            # as the sentences of JSON have it
            for sign, plain in zip("µΩ±²", ("u", "ohm", "+-", "^2")):
                text = text.replace(sign, plain)
            check("2 drops" in shown.title(), shown.title())
            for name, value in answer["parameters"].items():
                unit = re.escape(value["unit"])
                row = re.search(rf" {name} ([\d.]+)\(\d+\) {unit}; 95 %: ([\d.]+) to ([\d.]+) {unit}$", text, re.M)
                check(row, f"{name} stands in a table: {text[:800]}")
                for shown_number, key in zip(row.groups(), ("value", "lower_95", "upper_95")):
                    off = abs(float(shown_number) - value[key])
                    check(off < 0.1 * value["combined_standard_uncertainty"], row.group(0))
            for row in answer["budget"]:
                check(f"{row['cause']} {row['type'] or '-'} " in text, row)
            sentences = [finding["text"] for finding in answer["findings"]]
            check(len(sentences) >= 5, sentences)
            for words_shown in [*sentences, "haptometer 0.", "--report", "converged yes",
                                "open <1> & on.csv", f"{answer['correlation_kv_bv_km'][0][1]:.3f}"]:
                check(words_shown in text, f"'{words_shown}' is on the page")

            figures = shown.figures()
            check(len(figures) == 4, "a figure a record, one of the poles, one of what is left out")
            drawn = shown.figure_text()
            for label in ("time / ms", "residual / noise", "frequency / Hz", "decay rate / (1/s)"):
                check(label in drawn, f"an axis says {label}: {drawn}")
            check(any("silent.csv: not fitted: " in word for word in drawn), drawn)

            shown.check_that_it_is_sound(MOST_PAGES)


if __name__ == "__main__":
    main()
