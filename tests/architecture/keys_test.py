"""Reads tools/: a key of a result document stands as a literal once. A key is written as the first string in
braces of a Key (`Key kRate{"rate_hz"`), of an argument of a function Add... or ...Section, or as a section's
`.name = "..."`; in the sources that write JSON in any braces and brackets. Elsewhere in braces, a name followed
by a label and a unit is refused: it is to be a Key."""
import collections
import os
import pathlib
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import check

TOKEN = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\])+\'|\w+|\S', re.DOTALL)
KEY = re.compile(r'"([A-Za-z]\w*)"')
TAKES_KEYS = re.compile(r"add|Add|\w*Section$|PointList$|ListOf$|exponent$|field$")
WRITERS = ("tools/document/document.cc", "tools/document/json.cc")
NO_SECTIONS = ("SensorHead", "Channel")  # have a `.name` of their own


def tokens(text):
    """(token, line) without comments."""
    return [(match.group(), text.count("\n", 0, match.start()) + 1) for match in TOKEN.finditer(text)
            if not match.group().startswith(("//", "/*"))]


def keys(text, writes_json=False):
    """(key, line, whether it is written as a key) of every key in a source."""
    found = tokens(text)
    word = lambda at: found[at][0] if 0 <= at < len(found) else ""
    opened = []
    for at, (token, line) in enumerate(found):
        if token in "([{":
            opened.append(at)
        elif token in ")]}" and opened:
            opened.pop()
        match = KEY.fullmatch(token)
        if not match or not opened:
            continue
        begin = opened[-1]
        around = opened[-2] if len(opened) > 1 else -1
        if word(at - 1) == "=" and word(at - 2) == "name":
            if word(begin - 2) not in NO_SECTIONS:
                yield match[1], line, True
        elif begin != at - 1 or word(begin) == "(":
            continue
        elif "Key" in (word(begin - 1), word(begin - 2)) or writes_json:
            yield match[1], line, True
        elif word(begin - 1) in "(," and word(around) == "(" and TAKES_KEYS.match(word(around - 1)):
            yield match[1], line, True
        elif word(at + 1) == "," and word(at + 2).startswith('"') and (
                [word(at + 3), word(at + 4)] == [",", "document"] or word(at + 4) in UNITS):
            yield match[1], line, False


UNITS = set(re.findall(r"inline constexpr Unit (k\w+)",
                       pathlib.Path("tools/document/number_text.h").read_text(encoding="utf-8")))


def wrong(sources):
    """What stands twice, or not as a key, in sources by their path."""
    places = collections.defaultdict(list)
    for path, text in sources.items():
        for key, line, is_written_as_key in keys(text, path in WRITERS):
            places[key].append(f"{path}:{line}" + ("" if is_written_as_key else " (write Key{...})"))
    lost = [f"{key}: {', '.join(at)}" for key, at in sorted(places.items()) if len(at) > 1 or "(" in at[0]]
    return lost, len(places)


def check_search():
    """Each place where a key may stand is found, and what is none is not."""
    made_up = {
        "constant": 'constexpr Key kRate{"rate_hz", "rate"};',
        "designated": 'constexpr std::array kCells{Key{"rate_hz"}};',
        "item": 'section.Add({"rate_hz", "rate"}, 1);',
        "argument": 'AddFitted(section,\n  {"rate_hz"}, fit);',
        "section": 'Section inner{.name = "rate_hz"};',
        "assigned": 'if (x) { inner.name = "rate_hz"; }',
        "list": 'ListOf({.name = "rate_hz"}, trials);',
    }
    for what, text in made_up.items():
        check([(key, good) for key, _, good in keys(text)] == [("rate_hz", True)], f"the search misses: {what}")
    check(list(keys('return {{"rate_hz", 1}};', True)) == [("rate_hz", 1, True)], "the search misses JSON")
    check(list(keys('json["rate_hz"] = 1;', True)) == [("rate_hz", 1, True)], "the search misses a subscript")
    check(list(keys('{{{"rate_hz", "rate", kHertz}}};')) == [("rate_hz", 1, False)], "the search misses a table")
    none = ('// section.Add({"rate_hz"}, 1);\n findings.Note(kFast, {{"rate_hz", 1}}); options.Positional("rate_hz");'
            'SensorHead head{.name = "rate_hz"}; section.Add({document::kRate.name, "rate_hz"}, 1);')
    check(not list(keys(none)), f"no keys: {list(keys(none))}")
    twice = {"a.cc": made_up["constant"], "b.cc": made_up["item"]}
    check(wrong(twice) == (["rate_hz: a.cc:1, b.cc:1"], 1), f"a key that stands twice: {wrong(twice)}")


def check_keys():
    sources = {path.as_posix(): path.read_text(encoding="utf-8")
               for path in sorted(pathlib.Path("tools").rglob("*")) if path.suffix in (".cc", ".h")}
    lost, count = wrong(sources)
    check(count > 500, f"{count} keys found")
    check(not lost, "keys that stand twice; of two verbs they go to tools/document/keys.h:\n" + "\n".join(lost))


check_search()
check_keys()
