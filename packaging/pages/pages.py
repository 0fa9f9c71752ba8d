"""The pages of the tree as HTML: packaging/pages/pages.py TREE FOLDER

README.md becomes index.html. Links between pages lead to their HTML, pictures are copied, and a link that leads
nowhere ends the program with status 1.
"""
import html.parser
import pathlib
import shutil
import subprocess
import sys
import urllib.parse

HERE = pathlib.Path(__file__).resolve().parent
PICTURES = {".svg", ".png"}


def pages(tree):
    """Paths of the pages within the tree."""
    names = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "python/README.md", "tests/long/README.md"]
    return [pathlib.Path(name) for name in names] + [
        path.relative_to(tree) for path in sorted((tree / "docs").rglob("*.md"))]


def html_name(page):
    return page.with_name("index.html") if page.name == "README.md" else page.with_suffix(".html")


def write_page(tree, folder, page):
    text = (tree / page).read_text(encoding="utf-8")
    title = next(line.removeprefix("# ") for line in text.splitlines() if line.startswith("# "))
    written = folder / html_name(page)
    written.parent.mkdir(parents=True, exist_ok=True)
    subprocess.run(
        ["pandoc", "--from=gfm", "--to=html5", f"--template={HERE / 'page.html'}", f"--lua-filter={HERE / 'links.lua'}",
         f"--metadata=pagetitle:{title}", f"--variable=home:{'../' * (len(page.parts) - 1)}index.html",
         f"--output={written}"],
        input=text, text=True, encoding="utf-8", check=True)


class Anchors(html.parser.HTMLParser):
    """What a page of HTML links to, and the names of its places."""

    def __init__(self, path):
        super().__init__()
        self.targets, self.names = [], set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.targets += [values[key] for key in ("href", "src") if values.get(key)]
        self.names |= {values[key] for key in ("id", "name") if values.get(key)}


def lost_links(folder):
    """FILE: TARGET of the links within the folder whose file or place is not there."""
    read = {path: Anchors(path) for path in sorted(folder.rglob("*.html"))}
    lost = []
    for path, page in read.items():
        for target in page.targets:
            parts = urllib.parse.urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            name, place = urllib.parse.unquote(parts.path), urllib.parse.unquote(parts.fragment)
            file = (path.parent / name).resolve() if name else path
            if not file.is_file() or (place and place not in read[file].names):
                lost.append(f"{path.relative_to(folder)}: {target}")
    return lost


def main():
    tree, folder = (pathlib.Path(name).resolve() for name in sys.argv[1:])
    for page in pages(tree):
        write_page(tree, folder, page)
    for picture in (tree / "docs").iterdir():
        if picture.suffix in PICTURES:
            shutil.copy(picture, folder / "docs")
    lost = lost_links(folder)
    if lost:
        sys.exit("links that lead nowhere:\n" + "\n".join(lost))


if __name__ == "__main__":
    main()
