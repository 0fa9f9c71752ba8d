"""Reads docs/ and the sources: each test that docs/developer/hard_case_tests.md names exists; no page and no message in a
source uses a word that the glossary lists as not to be used; links between pages, paths in code, sources that
comments name and names in the table of what to change where lead to what exists."""
import fnmatch
import os
import pathlib
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import check
from words import GLOSSARY, MARK, comments, literals, message, pattern_of, uses, words_not_to_use

HARD_CASES = pathlib.Path("docs/developer/hard_case_tests.md")
# what users get; tests/, bench/ and fuzz/ are for developers
PRODUCT = ["acquire", "base", "dsp", "fit", "sim", "tools", "trial"]

CASE = re.compile(r"^(?:TEST|TEST_F|TEST_P|TYPED_TEST|RC_GTEST_PROP|RC_GTEST_FIXTURE_PROP)\(\s*(\w+),\s*(\w+)",
                  re.MULTILINE)
SCRIPT = re.compile(r"(?:haptometer_(?:script|reference|unsanitized)_test\(\s*|add_test\(NAME )([\w.]+(?:\$\{\w+\})?)")


def pages():
    """The pages of the project, by path from its root."""
    found = sorted(pathlib.Path("docs").rglob("*.md")) + [
        pathlib.Path(name) for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")]
    check(len(found) > 10, f"{len(found)} pages")
    return found


def prose(text):
    """The text with its code, its links' targets and its comments taken out; as many lines."""
    blank = lambda match: re.sub(r"[^\n]", " ", match.group())
    text = re.sub(r"^```.*?^```$", blank, text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"^(?: {4}|\t).*$", blank, text, flags=re.MULTILINE)
    text = re.sub(r"`[^`]*`", blank, text)
    text = re.sub(r"\]\([^)]*\)", blank, text)
    return re.sub(r"<!--.*?-->", blank, text, flags=re.DOTALL)


def product_sources():
    found = [path for room in PRODUCT for path in sorted(pathlib.Path(room).rglob("*.[ch]*"))
             if path.suffix in (".cc", ".h")]
    check(len(found) > 400, f"{len(found)} sources")
    return found


def check_words():
    tells = pattern_of(["tells"])
    check(list(uses(prose("A record\ntells more.\n"), tells)) == [(2, "tells")], "the search finds nothing")
    check(not list(uses(prose("`tells`\n\n    tells\n"), tells)), "the search looks into code")
    pattern = pattern_of(words_not_to_use())
    wrong = []
    for page in pages():
        text = page.read_text(encoding="utf-8")
        text = text.split(MARK)[0] if page == GLOSSARY else text
        wrong += [f"{page}:{line}: '{word}'" for line, word in uses(prose(text), pattern)]
    check(not wrong, "words that the glossary replaces:\n" + "\n".join(wrong))


def check_messages():
    """Messages are the strings with a blank between letters, so keys and formats are none; comments are only counted."""
    source = 'f("a record "\n  "tells", R"(it tells)", "tells", "--tells {tells} more");  // a comment tells\n'
    tells = pattern_of(["tells"])
    found = [line for line, text in literals(source) for _ in uses(message(text), tells)]
    check(found == [1, 2], f"the search of messages finds lines {found}")
    pattern = pattern_of(words_not_to_use())
    wrong, in_comments = [], 0
    for path in product_sources():
        text = path.read_text(encoding="utf-8")
        for line, literal in literals(text):
            wrong += [f"{path}:{line}: '{word}' in \"{literal}\"" for _, word in uses(message(literal), pattern)]
        in_comments += sum(len(list(uses(comment, pattern))) for _, comment in comments(text))
    print(f"{in_comments} words in comments that the glossary replaces")
    check(not wrong, "words in messages that the glossary replaces:\n" + "\n".join(wrong))


def test_names():
    """ROOM.SUITE.NAME of the cases in C++, as ctest has them without an instance's name, and the scripts' names."""
    names = set()
    for path in pathlib.Path("tests").rglob("*.[ch]*"):
        parts = path.parts
        if path.suffix not in (".cc", ".h") or len(parts) < 3:
            continue
        room = f"dsp_{parts[2]}" if parts[1] == "dsp" else parts[1]
        names |= {f"{room}.{suite}.{name}" for suite, name in CASE.findall(path.read_text(encoding="utf-8"))}
    for path in list(pathlib.Path("tests").rglob("CMakeLists.txt")) + [pathlib.Path("bench/CMakeLists.txt")]:
        names |= {re.sub(r"\$\{\w+\}", "_", name) for name in SCRIPT.findall(path.read_text(encoding="utf-8"))}
    return names


def check_named_tests():
    names = test_names()
    rooms = {name.split(".")[0] for name in names}
    rows = HARD_CASES.read_text(encoding="utf-8").splitlines()
    named = {word for row in rows if row.startswith("|") for word in re.findall(r"`([a-z_]+\.[\w.*]+)`", row)}
    named = {word for word in named if word.split(".")[0] in rooms}
    check(len(names) > 1000 and len(named) > 100, f"{len(names)} tests, {len(named)} named")
    lost = sorted(word for word in named if not fnmatch.filter(names, word))
    check(not lost, f"{HARD_CASES} names tests that do not exist: {', '.join(lost)}")


def check_terms():
    """The glossary has each term once, in the order of the alphabet."""
    text = GLOSSARY.read_text(encoding="utf-8").split("## Words")[0]
    terms = [line.split("|")[1].strip().lower() for line in text.splitlines() if line.startswith("| ")][1:]
    check(len(terms) > 50, f"{len(terms)} terms")
    check(len(terms) == len(set(terms)), "a term stands twice")
    for before, after in zip(terms, terms[1:]):
        check(before < after, f"{GLOSSARY}: '{after}' stands behind '{before}'")


def check_links():
    lost = []
    for page in pages():
        for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", page.read_text(encoding="utf-8")):
            if "://" not in target and not (page.parent / target).exists():
                lost.append(f"{page}: {target}")
    check(not lost, "links that lead nowhere:\n" + "\n".join(lost))


def check_paths():
    """A path of a file or folder of the tree, in code, exists; NAME stands for a name to be chosen."""
    rooms = "acquire|base|bench|cmake|dev|dsp|fit|fixtures|fuzz|packaging|sim|tests|tools|trial|docs"
    lost = []
    for page in pages():
        for path in re.findall(rf"`((?:{rooms})/[\w./-]*)`", page.read_text(encoding="utf-8")):
            if "NAME" not in path and not pathlib.Path(path).exists():
                lost.append(f"{page}: {path}")
    check(not lost, "paths that do not exist:\n" + "\n".join(lost))


def check_places():
    """The table of what to change where: a name in brackets behind a file stands in that file, and not in a comment."""
    text = pathlib.Path("docs/explanation/architecture.md").read_text(encoding="utf-8").split("## To change something")[1]
    places = [(path, name) for path, names in re.findall(r"`([a-z]\w*/[\w./]+\.(?:h|cc))` \(([^()]*)\)", text)
              for name in re.findall(r"`([A-Za-z]\w+)`", names)]
    check(len(places) > 15, f"{len(places)} names")
    code = lambda path: re.sub(r"//.*", "", pathlib.Path(path).read_text(encoding="utf-8"))
    lost = [f"{path}: {name}" for path, name in places if not re.search(rf"\b{name}", code(path))]
    check(not lost, "names that the table of changes does not find:\n" + "\n".join(lost))


def check_comments():
    """A source that a comment in C++ names exists; of its path the end is enough."""
    foreign = {"ceres/ceres.h", "hdf5.h"}
    rooms = ["acquire", "base", "bench", "dsp", "fit", "fuzz", "sim", "tests", "tools", "trial"]
    sources = [path for room in rooms for path in pathlib.Path(room).rglob("*.[ch]*") if path.suffix in (".cc", ".h")]
    check(len(sources) > 500, f"{len(sources)} sources")
    ends = {"/".join(path.parts[k:]) for path in sources for k in range(len(path.parts))} | foreign
    lost = []
    for path in sources:
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            for name in re.findall(r"\b[\w/]+\.(?:h|cc)\b", line.partition("//")[2]):
                if name not in ends:
                    lost.append(f"{path}:{number}: {name}")
    check(not lost, "comments name sources that do not exist:\n" + "\n".join(lost))


check_words()
check_messages()
check_terms()
check_comments()
check_paths()
check_places()
check_named_tests()
check_links()
