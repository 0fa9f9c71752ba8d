"""The page of `study --report` for 96 trials, looked at in a real browser: below 2 MB, the table first, no number divided
on screen or paper, nothing cut at the right of A4.
"""
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import browser  # noqa: E402
from programs import check, run  # noqa: E402

MOST_BYTES = 2_000_000
MOST_PAGES = 14  # 96 trials, and as many inputs with their hashes, fill nine of them
A4_PX = 680      # 210 mm without margins of 15 mm, at 96 px an inch

# cells of numbers that take more than one line, and parts that reach beyond the page
DIVIDED = """
return [...document.querySelectorAll('tbody .number')].filter(cell => {
  const range = document.createRange();
  range.selectNodeContents(cell);
  return new Set([...range.getClientRects()].map(box => Math.round(box.top))).size > 1;
}).map(cell => cell.textContent);"""
BEYOND = """
const width = document.documentElement.clientWidth;
return [...document.querySelectorAll('body *')].filter(part => part.getBoundingClientRect().right > width + 1)
  .map(part => part.tagName + ' ' + part.textContent.slice(0, 60));"""


def main():
    with tempfile.TemporaryDirectory() as directory:
        subprocess.run([sys.executable, "fixtures/generate/study.py", directory], check=True)
        report = os.path.join(directory, "study.html")
        run("study", os.path.join(directory, "study.toml"), "--report", report)
        check(os.path.getsize(report) < MOST_BYTES, os.path.getsize(report))
        with browser.page(report) as shown:
            driver = shown.driver
            numbers = driver.execute_script("return document.querySelectorAll('tbody .number').length;")
            check(numbers > 300, numbers)
            check(driver.execute_script(DIVIDED) == [], "a number is divided on a screen")
            first = driver.execute_script(
                "const table = document.querySelector('table.data');"
                "return [table.rows[0].cells[0].textContent, table.getBoundingClientRect().bottom,"
                "        document.querySelector('figure').getBoundingClientRect().top];")
            check(first[0] == "condition" and first[1] < first[2] and first[1] < 900, first)
            text = shown.text()
            for words in ("ia1 against stock", "contrasts", "Hedges g", "what differs, and what to consider", "design",
                          "sensor", "recorded", "imported", "means of the subjects", "methods", "Butterworth",
                          "the longest steady part of the drive", "Holm", "Computed with haptometer", "trials", "SHA-256", "µm"):
                check(words in text, f"'{words}' is on the page")
            check(" um" not in text.replace("um/", ""), "micrometres have their sign")
            drawn = shown.figure_text()
            for words in ("RMS displacement / µm", "mean difference / µm", "ratio of geometric means",
                          "a subject, mean of its trials", "ia1 against stock, n = 8"):
                check(words in drawn, f"'{words}' is in the figure: {drawn}")
            shown.check_that_it_is_sound(MOST_PAGES)
            # as it is printed
            driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
            driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                   {"width": A4_PX, "height": 1000, "deviceScaleFactor": 1, "mobile": False})
            check(driver.execute_script(DIVIDED) == [], driver.execute_script(DIVIDED))
            check(driver.execute_script(BEYOND) == [], driver.execute_script(BEYOND)[:5])


if __name__ == "__main__":
    main()
