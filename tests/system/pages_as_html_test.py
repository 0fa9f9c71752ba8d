"""packaging/pages/pages.py: every page becomes HTML, a link or picture that leads nowhere is found."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "packaging/pages")]
from programs import check, skip  # noqa: E402
from pages import Anchors, lost_links  # noqa: E402


def main():
    if shutil.which("pandoc") is None:
        skip("no pandoc")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        made = subprocess.run([sys.executable, "-B", "packaging/pages/pages.py", ".", name],
                              capture_output=True, text=True)
        check(made.returncode == 0 and not made.stderr, made.stderr)
        read = {path: Anchors(path) for path in folder.rglob("*.html")}
        sources = len(list(pathlib.Path("docs").rglob("*.md"))) + 5  # README, CHANGELOG, CONTRIBUTING, Python, long runs
        check(len(read) == sources, f"{len(read)} pages of {sources}")
        targets = sum(len(page.targets) for page in read.values())
        check(targets > 500, f"{targets} links")
        check("docs/trial.svg" in read[folder / "index.html"].targets, "a page has lost its picture")
        # what a link leads to is taken away: a picture, and a place on a page
        os.remove(folder / "docs/fit.png")
        glossary = folder / "docs/explanation/glossary.html"
        glossary.write_text(glossary.read_text().replace(' id="', ' class="'))
        first = folder / "index.html"
        first.write_text(first.read_text() + '<a href="docs/explanation/glossary.html#words">')
        lost = lost_links(folder)
        check("docs/reference/fit-lra.html: ../fit.png" in lost, lost)
        check("index.html: docs/explanation/glossary.html#words" in lost, lost)
    print(len(read), "pages,", targets, "links")


if __name__ == "__main__":
    main()
