"""Reads the rooms below tools: their findings are kinds with numbers. No text of several words goes into a finding,
no result holds sentences, and no literal names an option; tools/ makes sentences and names options."""
import os
import pathlib
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import check

ROOMS = ("base", "trial", "acquire", "dsp", "sim", "fit")
COMMENT = re.compile(r'("(?:\\.|[^"\\\n])*")|//[^\n]*|/\*.*?\*/', re.DOTALL)
STRING = re.compile(r'"(?:\\.|[^"\\\n])*"')
OPTION = re.compile(r"(?<![\w-])--[a-z]")
# what makes a finding, up to the end of its statement
FINDING = re.compile(r"(?:\b(?:Refuse|Doubt|Note|Add)\(\s*\{?[^;\"]*?\bk[A-Z]\w*|\bFindingNumber\b|\bnumbers\s*=|"
                     r"\bnumbers\.emplace_back\()[^;]*;")
SENTENCES = ("remarks|reasons|doubts|assumptions|assumed|disturbances|found|findings|undetermined|warnings|refusals|"
             "complaints|messages|sentences")
SENTENCE = "remark|reason|why|doubt|how|because|warning|refusal|verdict|message|sentence|explanation"
RESULT = re.compile(rf"std::(?:vector<std::string>\s+(?:{SENTENCES})|(?:string|optional<std::string>)\s+(?:{SENTENCE}))"
                    r"(?:\s*=[^;]*|\s*\{[^;]*)?;")
PARSED = re.compile(r"\b(?:what|why|reason|remark|finding|sentence|remedy)\w*\.(?:starts_with|ends_with|contains|find)\(")


def code(text):
    """The text without comments; as many lines."""
    return COMMENT.sub(lambda match: match[1] or re.sub(r"[^\n]", " ", match[0]), text)


def options(text):
    """Literals that name an option."""
    return [match for match in STRING.finditer(text) if OPTION.search(match[0])]


def sentences(text, is_header):
    """Texts of several words that a finding is given, what reads sentences, and the results that hold them."""
    wordy = lambda statement: "fmt::format(" in statement or any(" " in word for word in STRING.findall(statement))
    found = [match for match in FINDING.finditer(text) if wordy(match[0])]
    return found + list(PARSED.finditer(text)) + (list(RESULT.finditer(text)) if is_header else [])


def check_search():
    """Each search finds what it is for, and no more."""
    named = ('Usage("", "is missing", "give --mass");', 'auto text = "--mass=1g";')
    for text in named:
        check(len(options(code(text))) == 1, f"the search misses: {text}")
    for text in ('Usage("", "is missing", "give <mass>");', "// --mass", 'a = "a--b"; --a;', 'line = "-----";'):
        check(not options(code(text)), f"the search finds: {text}")
    wordy = ('findings.Doubt(FindingKind::kTooShort, {{"why", std::string("is too short")}});',
             'found.Add({.kind = FindingKind::kSlow,\n .numbers = {{"limit", std::string("the wire")}}});',
             'findings.Note(kSlow, {{"why", fmt::format("{}", n)}});',
             'Finding why{.kind = kSlow, .numbers = {{"of", std::string("the drive")}}};',
             'reason.numbers.emplace_back("of", std::string("the drive"));',
             "std::vector<std::string> remarks;", "std::vector<std::string> reasons{};", "std::string why;",
             'if (error.what.starts_with("holds")) return;')
    for text in wordy:
        check(len(sentences(code(text), True)) == 1, f"the search misses: {text}")
    terse = ('findings.Doubt(FindingKind::kTooShort, {{"needed_s", 1}});', '// findings.Note(kSlow, "a b");',
             'return CannotAnswer(name, "is too short", "record longer");', "std::vector<std::string> names;",
             'table.Refuse("first", "is missing", "a line needs two points");',
             'if (source.starts_with("device")) return;')
    for text in terse:
        check(not sentences(code(text), True), f"the search finds: {text}")


def check_rooms():
    sources = [path for room in ROOMS for path in sorted(pathlib.Path(room).rglob("*")) if path.suffix in (".cc", ".h")]
    check(len(sources) > 300, f"{len(sources)} sources")
    named, worded, made = [], [], 0
    for path in sources:
        text = code(path.read_text(encoding="utf-8"))
        place = lambda match: f"{path}:{text.count(chr(10), 0, match.start()) + 1}: {' '.join(match[0].split())[:100]}"
        named += [place(match) for match in options(text)]
        worded += [place(match) for match in sentences(text, path.suffix == ".h")]
        made += len(FINDING.findall(text))
    check(made > 100, f"{made} findings")
    check(not named, "options are named in tools/ alone (a <mass> is replaced there):\n" + "\n".join(named))
    check(not worded, "findings are kinds and numbers; sentences stand in tools/document/:\n" + "\n".join(worded))


check_search()
check_rooms()
