"""The words that the glossary lists as not to be used, and where they stand in a page, a help text or a source."""
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
GLOSSARY = pathlib.Path("docs/explanation/glossary.md")
MARK = "<!-- words not to use -->"

# a comment, a raw string, a string or a character of C++
TOKEN = re.compile(r"""//[^\n]*|/\*.*?\*/|R"(\w*)\((?P<raw>.*?)\)\1"|"(?P<text>(?:[^"\\\n]|\\.)*)"|'(?:[^'\\\n]|\\.)+'""",
                   re.DOTALL)
# in a message: an option, a word for an option (<rate>), the place of a number, code
NO_PROSE = re.compile(r"--[\w-]+|<\w+>|\{[^{}]*\}|`[^`]*`")


def words_not_to_use():
    """The first column of the glossary's marked table."""
    text = (ROOT / GLOSSARY).read_text(encoding="utf-8")
    assert text.count(MARK) == 1, f"{GLOSSARY} has no single {MARK}"
    rows = [line.split("|")[1].strip() for line in text.split(MARK)[1].splitlines() if line.startswith("|")]
    assert rows[0] == "word" and len(rows) > 20, f"{len(rows)} rows below the mark"
    return rows[2:]


def pattern_of(words):
    """One expression for all words: whole words, without case, blanks may be line ends."""
    each = [r"\s+".join(map(re.escape, word.split())) for word in sorted(words, key=len, reverse=True)]
    return re.compile(r"\b(?:" + "|".join(each) + r")\b", re.IGNORECASE)


def uses(text, pattern):
    """(line, word) of every word that stands in the text."""
    for match in pattern.finditer(text):
        yield text.count("\n", 0, match.start()) + 1, " ".join(match.group().split())


def message(text):
    """A message without what is no prose in it; as many lines."""
    return NO_PROSE.sub(lambda match: re.sub(r"[^\n]", " ", match.group()), text)


def literals(source):
    """(line, text) of the strings of a C++ source that hold a blank between letters; adjacent strings are one."""
    found = []
    end = 0
    for match in TOKEN.finditer(source):
        if match["raw"] is None and match["text"] is None:
            continue
        text = match["raw"] if match["raw"] is not None else match["text"]
        if found and not source[end:match.start()].strip():
            found[-1][1] += text
        else:
            found.append([source.count("\n", 0, match.start()) + 1, text])
        end = match.end()
    return [(line, text) for line, text in found if re.search(r"[A-Za-z][,;:]? [A-Za-z]", text)]


def comments(source):
    """(line, text) of the comments of a C++ source."""
    for match in TOKEN.finditer(source):
        if match["raw"] is None and match["text"] is None and match.group()[0] == "/":
            yield source.count("\n", 0, match.start()) + 1, match.group()
