#!/usr/bin/env python3
"""The page of `reproduce --report`, looked at in a real browser: it holds every row that `--json`
gives and nine figures, fetches nothing, fits a narrow screen and prints.
"""
import json
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import browser  # noqa: E402
from programs import check, run  # noqa: E402

MOST_PAGES = 25
FIGURES = 9


def main():
    with tempfile.TemporaryDirectory() as directory:
        report = os.path.join(directory, "thesis.html")
        answer = json.loads(run("reproduce", "--chain", "--report", report, "--json").stdout)
        check(answer["files"] == [report], answer["files"])
        check(os.path.getsize(report) < 3_000_000, "the page is no larger than 3 MB")
        with browser.page(report) as shown:
            text = shown.text()
            for row in answer["rows"]:
                check(row["what"] in text, row["what"])
            for row in answer["chain"]:
                check(row["quantity"] in text, row["quantity"])
            check(len(shown.figures()) == FIGURES, shown.figures())
            words = shown.figure_text()
            for label in ("contact radius / mm", "frequency / Hz", "reference / V", "x / mm"):
                check(label in words, f"an axis says {label}: {words}")
            shown.check_that_it_is_sound(MOST_PAGES)
    print("the page is sound")


if __name__ == "__main__":
    main()
