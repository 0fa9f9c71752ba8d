"""A real browser for the tests that look at a report: Chromium, headless, on one local file.

  with browser.page(path) as shown: shown.text(), shown.figures(), ...
"""
import contextlib
import os
import pathlib
import tempfile

from programs import check, skip

WIDE = (1280, 900)
NARROW = (375, 700)

# nothing of these may look for the network
QUIET = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync",
         "--disable-dev-shm-usage"]


class Page:
    def __init__(self, driver):
        self.driver = driver

    def text(self):
        """What a reader sees, as text."""
        return self.driver.find_element("tag name", "body").text

    def title(self):
        return self.driver.title

    def figures(self):
        """Width and height on the screen of every drawing, and how many marks it holds."""
        return self.driver.execute_script(
            "return [...document.querySelectorAll('figure svg')].map(svg => {"
            "  const box = svg.getBoundingClientRect();"
            "  return [box.width, box.height, svg.querySelectorAll('path, polyline, line').length];"
            "});")

    def figure_text(self):
        """The words inside the drawings: titles, axes, keys."""
        return self.driver.execute_script(
            "return [...document.querySelectorAll('figure svg text')]"
            ".map(t => t.textContent.trim());")

    def fetched(self):
        """What the page asked for besides itself: nothing, when it is self-contained."""
        return self.driver.execute_script(
            "return performance.getEntriesByType('resource').map(entry => entry.name);")

    def complaints(self):
        """Errors in the browser's own log."""
        return [entry["message"] for entry in self.driver.get_log("browser")
                if entry["level"] == "SEVERE"]

    def overflow(self, size):
        """Pixels by which the page is wider than a window of `size`."""
        self.driver.set_window_size(*size)
        return self.driver.execute_script(
            "return document.documentElement.scrollWidth - document.documentElement.clientWidth;")

    def printed_pages(self):
        """Pages of paper, counted in the PDF that the browser prints."""
        import base64
        import re
        pdf = base64.b64decode(self.driver.print_page())
        return len(re.findall(rb"/Type\s*/Page\b", pdf))

    def check_that_it_is_sound(self, most_pages):
        """Complete in itself, without errors, legible on every screen and on paper."""
        check("nan" not in self.text().lower().split(), "no NaN is shown")
        for width, height, marks in self.figures():
            check(width > 300 and height > 200 and marks > 20, self.figures())
        check(self.fetched() == [], self.fetched())
        check(self.complaints() == [], self.complaints())
        check(self.overflow(NARROW) <= 0, "a telephone shows all of it")
        check(self.overflow(WIDE) <= 0, "a screen shows all of it")
        check(1 <= self.printed_pages() <= most_pages, self.printed_pages())

    def picture(self):
        """A screenshot, as PNG."""
        return self.driver.get_screenshot_as_png()


@contextlib.contextmanager
def page(path):
    """Opens the HTML file `path` as a user would."""
    try:
        from selenium import webdriver
        from selenium.webdriver.chrome.options import Options
        from selenium.webdriver.chrome.service import Service
    except ImportError:
        skip("needs python3-selenium")
    if not os.path.exists("/usr/bin/chromedriver"):
        skip("needs chromium-driver")
    with tempfile.TemporaryDirectory() as profile:
        options = Options()
        options.binary_location = "/usr/bin/chromium"
        for word in [*QUIET, f"--user-data-dir={profile}", "--window-size=%d,%d" % WIDE]:
            options.add_argument(word)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        driver = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
        try:
            driver.set_page_load_timeout(30)
            driver.get(pathlib.Path(path).absolute().as_uri())
            yield Page(driver)
        finally:
            driver.quit()
