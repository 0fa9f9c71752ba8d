"""Seeds faults one at a time in the numerical code and asks whether the tests find them.

    mutate.py [--seed N] [--count N] [--rooms sim,fit] [--part I/N] [--results FILE.jsonl] [--work FOLDER]
              [--own] [--again]
    mutate.py --report [--results FILE.jsonl]

Each fault is put into a copy of the tree (in FOLDER), which is built on its own; the tree itself is never
changed. The test program of the fault's room runs first: the test file that mirrors the source, then all of
them. What it does not find, the hard cases, the tests of the verbs and their pinned numbers (tests/golden) may (not
with --own).
A line of JSON per fault goes to the results: caught, survived, same-program (the fault changes no program),
does-not-compile, timeout. A run begun again with the same options goes on behind what is there; --again tries
survivors that have no word in mutants.toml once more. With --part 1/2 and 2/2, in a FOLDER each, two commands share
the faults and the results.
tests/long/mutants.toml says of each survivor why it is none ("equivalent: ..."), which other test found it ("found by
..."), or which test was added since. --report leaves out the first and counts the second as caught; it ends with
status 1 while a survivor stands without a word there, or less than 92 % of the others are caught.
"""
import argparse
import hashlib
import json
import os
import pathlib
import random
import re
import resource
import shutil
import subprocess
import sys
import time
import tomllib
from dataclasses import dataclass

ROOT = pathlib.Path(__file__).resolve().parents[2]
VERDICTS = ROOT / "tests/long/mutants.toml"
ROOMS = ("base", "trial", "acquire", "dsp", "sim", "fit")
# the test programs that a fault in a room must pass, in this order; dsp has one of its own for each folder
PROGRAMS = {"base": ("base_test", "trial_test"), "trial": ("trial_test", "hard_cases_test", "tools_test"),
            "acquire": ("acquire_test", "hard_cases_test", "tools_test"),
            "dsp": ("dsp_analysis_test", "hard_cases_test", "tools_test"),
            "sim": ("sim_test", "hard_cases_test", "tools_test"), "fit": ("fit_test", "hard_cases_test", "tools_test")}
VERBS = "haptometer"  # tests/golden runs it
BUILD = "build/release"  # of the copy
LEAST_CAUGHT = 0.92
MEMORY_BYTES = 6 << 30  # of a test program: a fault may ask for all there is
FOUND = ("caught", "timeout")

TEXT = re.compile(r"""//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:[^"\\\n]|\\.)*"|(?<!\w)'(?:[^'\\\n]|\\.)+'"""
                  r"|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", re.DOTALL | re.MULTILINE)
NUMBER = r"(?<![\w.'])\d[\d']*(?:\.\d*)?(?:e[-+]?\d+)?(?![\w.'])"
SUITE = re.compile(r"^(?:TEST|TEST_F|TEST_P|RC_GTEST_PROP)\(\s*(\w+)", re.MULTILINE)
# kind, what it looks for, what it puts there; sources are formatted: a blank stands on both sides of an operator
SWAPS = (
    ("sign", r" \+(=?) ", r" -\1 "),
    ("sign", r" -(=?) ", r" +\1 "),
    ("sign", r"(?:(?<=[(,=*/{n] )|(?<=[(\[{]))-(?=[A-Za-z_(\d])", ""),
    ("index", r"(?<=[\w\])]\[)([^\[\]{},&=]+)(?=\])", r"\1 + 1"),
    ("index", r" [-+] 1(?![\w.'])", ""),
    ("index", r"(?<=; )(\w+) (<=?) (?=[^;{}]+; (?:\+\+|--|\w+ [-+]=))", r"\1 + 1 \2 "),
    ("comparison", r" ([<>])(=?) (?!=)", None),
    ("comparison", r" ([!=])= ", None),
    ("comparison", r"\bstd::(min|max)\(", None),
    ("constant", NUMBER, None),
    ("unit", r"\b2(?:\.0)? \* (?=(?:std::)?numbers::pi|kPi\b)", ""),
    ("unit", r"\bstd::sqrt(?=\()", ""),
    ("unit", r"\bSquare(?=\((?!\w+ ))", ""),
    ("unit", r"\b(\w+) \* \1\b(?![\w(.\[:])", r"\1"),
    ("unit", r"(?<![\w.'])1e-?[1-9]\d?(?![\w.'])", "1.0"),
    ("unit", r"(?:(?<= [*/+-] )|(?<=return ))([a-z]\w*_(?:s|m|hz|n|v|a|m_s|rad))(?![\w.(\[{:-])", r"\1 * 1e3"),
)
OTHER = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "std::min(": "std::max(",
         "std::max(": "std::min("}
KINDS = tuple(dict.fromkeys([kind for kind, _, _ in SWAPS] + ["term"]))


@dataclass(frozen=True)
class Fault:
    """The text from begin to end of the file is replaced."""
    file: str
    begin: int
    end: int
    kind: str
    text: str

    def applied(self, source):
        return source[:self.begin] + self.text + source[self.end:]

    def row(self, source):
        """What the results say of it: where, and its lines before and after."""
        first = source.rfind("\n", 0, self.begin) + 1
        last = source.find("\n", self.end)
        tidy = lambda text: " ".join(text.split())
        return {"file": self.file, "line": source.count("\n", 0, self.begin) + 1, "column": self.begin - first + 1,
                "kind": self.kind, "before": tidy(source[first:last]),
                "after": tidy(source[first:self.begin] + self.text + source[self.end:last])}


def closing(code, at, stops):
    """Where the expression that begins at `at` ends: one of `stops` at its own depth, or what closes around it."""
    depth = 0
    while at < len(code):
        if depth == 0 and any(code.startswith(stop, at) for stop in stops):
            return at
        depth += (code[at] in "([{") - (code[at] in ")]}")
        if depth < 0:
            return at
        at += 1
    return at


def without_text(source):
    """The code with blanks for comments, literals, directives, static assertions and what a check says; as long."""
    blank = lambda text: re.sub(r"[^\n]", " ", text)
    code = TEXT.sub(lambda match: blank(match[0]), source)
    for match in re.finditer(r"\b(static_assert|HAPTOMETER_CHECK)\(", code):
        end = closing(code, match.end(), ())
        begin = match.end() if match[1] == "static_assert" else closing(code, match.end(), (",",))
        code = code[:begin] + blank(code[begin:end]) + code[end:]
    return code


def changed_number(text):
    """The number 1 % larger; a small integer one larger, a zero with a point 0.01."""
    digits = text.replace("'", "")
    if digits.isdigit():
        return str(int(digits) + max(1, int(digits) // 100))
    return repr(float(digits) * 1.01 or 0.01)


def replacement(kind, match, text):
    if text is not None:
        return match.expand(text)
    if kind == "constant":
        return changed_number(match[0])
    operator = match[0].strip()
    return match[0].replace(operator, OTHER[operator])


def terms(file, code):
    """Each summand behind a + or -, deleted."""
    for match in re.finditer(r"(?<=[\w)\]]) [-+]\s(?=\s*[\w(*-])", code):
        end = closing(code, match.end(), (",", ";", " + ", " - ", " < ", " > ", " <= ", " >= ", " == ", " != ", " && ",
                                          " || ", " ? ", " : ", "\n\n"))
        if not code[match.end():end].strip().isdigit():
            yield Fault(file, match.start(), end, "term", "")


def faults(file, source):
    """All faults of one source, in the order of their kinds."""
    code = without_text(source)
    found = []
    for kind, pattern, text in SWAPS:
        for match in re.finditer(pattern, code):
            word = replacement(kind, match, text)
            if word != match[0]:
                found.append(Fault(file, match.start(), match.end(), kind, word))
    return found + list(terms(file, code))


def files_of(tree):
    """The files of a tree without builds, Git's own and Python's."""
    found = (path for top in sorted(tree.iterdir()) if top.name not in ("build", ".git")
             for path in ([top] if top.is_file() else sorted(top.rglob("*"))))
    return [str(path.relative_to(tree)) for path in found if path.is_file() and "__pycache__" not in path.parts]


def choice(tree, rooms, seed):
    """Faults without end of the choice: a kind at random, then one of its faults, none twice."""
    by_kind = {kind: [] for kind in KINDS}
    for name in files_of(tree):
        if name.split("/")[0] in rooms and name.endswith((".cc", ".h")):
            for fault in faults(name, (tree / name).read_text(encoding="utf-8")):
                by_kind[fault.kind].append(fault)
    numbers = random.Random(seed)
    while any(by_kind.values()):
        some = by_kind[numbers.choice(KINDS)]
        if some:
            yield some.pop(numbers.randrange(len(some)))


class Copy:
    """A copy of the tree, the only one that is ever changed."""

    def __init__(self, work, rooms):
        self.rooms = rooms
        self.tree = pathlib.Path(work).absolute() / "tree"
        if self.tree.exists() and ((self.tree / ".git").exists() or self.tree.is_symlink()):
            sys.exit(f"{self.tree} is no copy of this command's own: it has a .git, or is a link")
        if ROOT.is_relative_to(self.tree.resolve()):
            sys.exit(f"{self.tree} holds the tree itself")

    def write(self, name, text):
        path = self.tree / name
        if path.exists() and (path.samefile(ROOT / name) or path.is_symlink()):
            sys.exit(f"{path} is the tree's own file")
        path.write_text(text, encoding="utf-8")

    def restore(self):
        """Copies what differs from the tree, so that only that is compiled again; the tree may change thereafter."""
        self.tree.mkdir(parents=True, exist_ok=True)
        names = files_of(ROOT)
        for name in set(files_of(self.tree)) - set(names):
            (self.tree / name).unlink()
        for name in names:
            path = self.tree / name
            if not path.exists() or path.read_bytes() != (ROOT / name).read_bytes():
                path.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(ROOT / name, path)
                shutil.copymode(ROOT / name, path)

    def configure(self):
        """Without warnings, and the rooms source by source: a fault costs the compilation of one source.

        An index beyond its container ends the program, as it does under the sanitizers of `./tools/check --deep`.
        """
        subprocess.run(["cmake", "--preset", "release", "-DHAPTOMETER_APART=" + ";".join(self.rooms),
                        "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -w -D_GLIBCXX_ASSERTIONS"], cwd=self.tree, check=True,
                       stdout=subprocess.DEVNULL)

    def build(self, program):
        """The hash of the program, None where it does not compile."""
        done = subprocess.run(["nice", "ninja", "-j1", program], cwd=self.tree / BUILD,
                              stdout=subprocess.DEVNULL)
        path = self.tree / BUILD / "bin" / program
        return hashlib.sha256(path.read_bytes()).hexdigest() if done.returncode == 0 else None

    def test(self, program, filter_, deadline_s):
        """(what came out, the first test that fails)."""
        command = [f"bin/{program}", f"--gtest_filter={filter_}", "--gtest_fail_fast"]
        if program == VERBS:
            command = ["/usr/bin/python3", str(self.tree / "tests/golden/golden.py"), "--check"]
        limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
        # other tests run beside these; the cache as under ctest
        folder = self.tree.parent / "tmp"
        folder.mkdir(exist_ok=True)
        own = {**os.environ, "TMPDIR": str(folder), "TEST_TMPDIR": str(folder), "HAPTOMETER_CACHE": "off",
               "HAPTOMETER_PROGRAMS": str(self.tree / BUILD / "bin")}
        try:
            done = subprocess.run(command, cwd=self.tree / BUILD, capture_output=True, timeout=deadline_s,
                                  preexec_fn=limit, env=own)
        except subprocess.TimeoutExpired:
            return "timeout", ""
        if done.returncode == 0:
            return "survived", ""
        output = done.stdout.decode(errors="replace")
        return "caught", output.split(":")[0] if program == VERBS else first_failure(output)


def first_failure(output):
    """The test that fails first, or during which the program ends; behind a failure GoogleTest names what it skips."""
    failed = re.findall(r"^\[  FAILED  \] (\S+?),? ", output, re.MULTILINE)
    ran = re.findall(r"^\[ RUN      \] (\S+)", output, re.MULTILINE)
    return (failed or ran[-1:] or ["does not start"])[0]


def programs_of(file, own):
    room, folder = file.split("/")[:2]
    first = [f"dsp_{folder}_test"] if room == "dsp" and (ROOT / f"tests/dsp/{folder}").is_dir() else []
    programs = list(dict.fromkeys([*first, *PROGRAMS[room], VERBS]))
    return programs[:1] if own else programs


def mirrored(file):
    """The suites of the test file that mirrors a source, or else of all test files beside it."""
    beside = ROOT / "tests" / pathlib.Path(file).parent
    one = beside / f"{pathlib.Path(file).stem}_test.cc"
    files = [one] if one.exists() else sorted(beside.glob("*_test.cc"))
    suites = {suite for path in files for suite in SUITE.findall(path.read_text(encoding="utf-8"))}
    return ":".join(f"{suite}.*" for suite in sorted(suites))


class Trial:
    """Builds and runs; remembers each program without a fault, and how long its tests take then."""

    def __init__(self, copy):
        self.copy = copy
        self.sound = {}

    def prepare(self, program):
        same = self.copy.build(program)
        begin = time.monotonic()
        result, test = self.copy.test(program, "*", 3600) if same else ("does-not-compile", "")
        if result != "survived":
            sys.exit(f"{program} fails without a fault: {result} {test}")
        return same, 60 + 5 * (time.monotonic() - begin)

    def judge(self, fault, source, own):
        """(verdict, test) of one fault."""
        verdict = "same-program"
        for program in programs_of(fault.file, own):
            self.copy.write(fault.file, source)
            if program not in self.sound:
                self.sound[program] = self.prepare(program)
            same, deadline_s = self.sound[program]
            self.copy.write(fault.file, fault.applied(source))
            built = self.copy.build(program)
            if built is None:
                return "does-not-compile", ""
            if built == same:
                continue
            for filter_ in ("*",) if program == VERBS else filter(None, (mirrored(fault.file), "*")):
                verdict, test = self.copy.test(program, filter_, deadline_s)
                if verdict in FOUND:
                    return verdict, test
        return verdict, ""


def key(row):
    """A fault's name that does not depend on its line number."""
    return row["file"], row["kind"], row["before"], row["after"]


def read_results(path):
    """The last row of each fault, by its place."""
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    rows = (json.loads(line) for line in lines if line.endswith("}"))
    return {key(row) + (row["line"], row["column"]): row for row in rows}


def verdicts():
    """What mutants.toml says of survivors."""
    with VERDICTS.open("rb") as file:
        return {key(fault): fault["verdict"] for fault in tomllib.load(file).get("fault", [])}


def run(options):
    copy = Copy(options.work, options.rooms)
    copy.restore()
    copy.configure()
    trial = Trial(copy)
    done = read_results(options.results)
    explained = verdicts()
    part, parts = options.part
    for number, fault in zip(range(options.count), choice(copy.tree, options.rooms, options.seed)):
        if number % parts != part - 1:
            continue
        source = (copy.tree / fault.file).read_text(encoding="utf-8")
        row = fault.row(source)
        known = done.get(key(row) + (row["line"], row["column"]))
        is_open = known and known["verdict"] == "survived" and key(known) not in explained
        if known and not (options.again and is_open):
            continue
        begin = time.monotonic()
        row["verdict"], row["test"] = trial.judge(fault, source, options.own)
        row |= {"seconds": round(time.monotonic() - begin, 1), "seed": options.seed}
        copy.write(fault.file, source)
        with options.results.open("a", encoding="utf-8") as file:
            file.write(json.dumps(row) + "\n")
        print("{verdict} in {seconds} s: {file}:{line} {kind} {test}".format(**row), flush=True)


def report(options):
    rows = list(read_results(options.results).values())
    explained = verdicts()
    count = {name: sum(row["verdict"] == name for row in rows)
             for name in ("caught", "timeout", "survived", "same-program", "does-not-compile")}
    survivors = [row for row in rows if row["verdict"] == "survived"]
    equivalent, elsewhere = (sum(explained.get(key(row), "").startswith(word) for row in survivors)
                             for word in ("equivalent", "found by"))
    found = sum(count[name] for name in FOUND) + elsewhere
    share = found / max(1, sum(count[name] for name in FOUND) + len(survivors) - equivalent)
    print(f"{len(rows)} faults:", ", ".join(f"{number} {name}" for name, number in count.items()),
          f"({equivalent} equivalent, {elsewhere} found by other tests)")
    print(f"{100 * share:.1f} % of those that change an answer are caught (bar {100 * LEAST_CAUGHT:.0f} %), "
          f"{sum(row['seconds'] for row in rows) / max(1, len(rows)):.0f} s a fault")
    unexplained = [row for row in survivors if key(row) not in explained]
    for row in unexplained:
        print("survivor without a verdict: {file}:{line}:{column} {kind}\n  {before}\n  {after}".format(**row))
    return 1 if unexplained or share < LEAST_CAUGHT else 0


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--seed", type=int, default=1)
    words.add_argument("--count", type=int, default=200)
    words.add_argument("--rooms", type=lambda text: tuple(text.split(",")), default=ROOMS)
    words.add_argument("--part", type=lambda text: tuple(map(int, text.split("/"))), default=(1, 1), metavar="I/N")
    words.add_argument("--results", type=pathlib.Path, default=ROOT / "build/mutants/results.jsonl")
    words.add_argument("--work", type=pathlib.Path, default=ROOT / "build/mutants")
    words.add_argument("--own", action="store_true", help="only the test program of the fault's own room")
    words.add_argument("--again", action="store_true", help="try survivors once more")
    words.add_argument("--report", action="store_true")
    options = words.parse_args()
    if not set(options.rooms) <= set(ROOMS):
        words.error(f"rooms are {', '.join(ROOMS)}")
    if len(options.part) != 2 or not 1 <= options.part[0] <= options.part[1]:
        words.error("--part is I/N, as 1/2")
    if options.report:
        return report(options)
    options.results.parent.mkdir(parents=True, exist_ok=True)
    return run(options)


if __name__ == "__main__":
    sys.exit(main())
