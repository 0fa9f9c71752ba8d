"""The page of `analyze --report`, looked at in a real browser: it shows the numbers that `--json`
gives, draws its figures, fetches nothing, fits a narrow screen and prints on a few pages.
"""
import json
import math
import os
import re
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import browser  # noqa: E402
from programs import check, run  # noqa: E402

RATE_HZ = 5000
MOST_PAGES = 6


def trial(path):
    """50 um at 225 Hz from 0.6 s to 1.8 s of 2.4 s, 30 mm of offset, tremor, a quiet beginning."""
    with open(path, "w") as file:
        file.write("# sampling_s = 0.0002\n# averages = 1\n# label.condition = <b>stock</b>\n"
                   "time_s,displacement_m\n")
        for k in range(int(2.4 * RATE_HZ)):
            t = k / RATE_HZ
            on = 0.6 <= t < 1.8
            noise = 1e-6 * math.sin(1e4 * math.sin(k * 12.9898))
            x = (30e-3 + 1e-4 * math.sin(2 * math.pi * 7.1 * t) + noise
                 + on * 50e-6 * math.sin(2 * math.pi * 225 * t))
            file.write(f"{t:.6f},{x:.9f}\n")


def main():
    with tempfile.TemporaryDirectory() as directory:
        data = os.path.join(directory, "driven & on.csv")
        report = os.path.join(directory, "report.html")
        trial(data)
        answer = json.loads(run("analyze", data, "--json").stdout)["trials"][0]
        run("analyze", data, "--report", report)
        check(os.path.getsize(report) < 3_000_000, "the page is no larger than 3 MB")

        with browser.page(report) as shown:
            text = shown.text()
            check("driven & on.csv" in shown.title(), shown.title())
            amplitude_um = answer["tone_amplitude_m"] * 1e6
            check(abs(amplitude_um - 50) < 0.5, amplitude_um)
            shown_rms = re.search(r"vibration \(RMS\)\s+([\d.]+)\(\d+\)\sµm", text)
            check(shown_rms, text[:500])
            off_um = float(shown_rms.group(1)) - answer["band_rms_m"] * 1e6
            check(abs(off_um) <= answer["band_rms_standard_uncertainty_m"] * 1e6, off_um)
            for words in ("20-500 Hz, Butterworth of order", "uncertainty of the RMS",
                          "noise floor", "225", "THD", "haptometer 0.", "--report", "imported", "SHA-256"):
                check(words in text, f"'{words}' is on the page")

            figures = shown.figures()
            check(len(figures) >= 2, figures)
            words = shown.figure_text()
            for label in ("time / s", "in band / µm", "frequency / Hz"):
                check(label in words, f"an axis says {label}: {words}")

            shown.check_that_it_is_sound(MOST_PAGES)


if __name__ == "__main__":
    main()
