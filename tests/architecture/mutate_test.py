"""Checks tests/long/mutate.py: it finds each kind of fault where one stands and none in what is no code, reads and
explains its results, and never changes the tree itself."""
import contextlib
import io
import json
import pathlib
import sys
import tempfile
import types

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE.parent / "long")]
import mutate
from programs import check

# each fault of a line of code: kind, and the line with it
CODE = {
    "y = a + b;": {("sign", "y = a - b;"), ("term", "y = a;")},
    "y -= b;": {("sign", "y += b;")},
    "y = -b;": {("sign", "y = b;")},
    "y = v[i];": {("index", "y = v[i + 1];")},
    "y = n - 1;": {("sign", "y = n + 1;"), ("index", "y = n;"), ("constant", "y = n - 2;")},
    "for (; i < n; ++i) F();": {("index", "for (; i + 1 < n; ++i) F();"), ("comparison", "for (; i <= n; ++i) F();")},
    "y = 0.5;": {("constant", "y = 0.505;")},
    "y = 0.0;": {("constant", "y = 0.01;")},
    "y = 1e3;": {("constant", "y = 1010.0;"), ("unit", "y = 1.0;")},
    "y = 1'000;": {("constant", "y = 1010;")},
    "y = a >= b;": {("comparison", "y = a > b;")},
    "y = a == b;": {("comparison", "y = a != b;")},
    "y = std::min(a, b);": {("comparison", "y = std::max(a, b);")},
    "y = 2 * std::numbers::pi;": {("unit", "y = std::numbers::pi;"), ("constant", "y = 3 * std::numbers::pi;")},
    "y = std::sqrt(a);": {("unit", "y = (a);")},
    "y = Square(a);": {("unit", "y = (a);")},
    "y = a * a;": {("unit", "y = a;")},
    "return g_m;": {("unit", "return g_m * 1e3;")},
    "y = f(a + g(b, c) * d, e);": {("sign", "y = f(a - g(b, c) * d, e);"), ("term", "y = f(a, e);")},
    # what is no code, or no number
    "// y = a + 1.5;": set(), "/* a < b\n - 1.5 */": set(), 'F("a + 1.5 \\" < 2");': set(), "F('2');": set(),
    'F(R"(a + 1.5)");': set(), "#define A (b + 1.5)": set(), "#if A > 2 \\\n + 3": set(),
    "static_assert(a + 1.5 < 2);": set(), 'HAPTOMETER_CHECK(a, "{} {}", b + 1.5, c[i]);': set(),
    "template <typename T>": set(), "std::vector<double> v2;": set(), "[a, &b]() { F(); }": set(),
    "auto p = [this, i] { F(); };": set(), "T* a_m;": set(), "a->b();": set(), "--a;": set(),
}


def ends(call, *arguments):
    """Whether the call ends the command."""
    try:
        call(*arguments)
    except SystemExit:
        return True
    return False


def check_faults():
    seen = set()
    for code, expected in CODE.items():
        source = f"before();\n{code}\nafter();\n"
        found = [(fault.kind, fault.applied(source)) for fault in mutate.faults("sim/a.cc", source)]
        wanted = {(kind, f"before();\n{line}\nafter();\n") for kind, line in expected}
        check(len(found) == len(wanted) and set(found) == wanted, f"{code}: {found}")
        seen |= {kind for kind, _ in expected}
    check(seen == set(mutate.KINDS), f"no example of {set(mutate.KINDS) - seen}")
    fault, = mutate.faults("sim/a.cc", "a();\n  y =\n    Half(0.5);\n")
    check(fault.row("a();\n  y =\n    Half(0.5);\n") == {
        "file": "sim/a.cc", "line": 3, "column": 10, "kind": "constant", "before": "Half(0.5);",
        "after": "Half(0.505);"}, "a fault's place")


def check_choice():
    chosen = lambda seed: [fault for _, fault in zip(range(60), mutate.choice(mutate.ROOT, ("sim",), seed))]
    some = chosen(1)
    check(some == chosen(1) and some != chosen(2) and len(set(some)) == 60, "a seed names its faults")
    check({fault.kind for fault in some} == set(mutate.KINDS), "sixty faults without a kind")
    check(all(fault.file.startswith("sim/") for fault in some), "a fault outside its room")


def check_copy(folder):
    """The copy is never the tree, nor a link into it, nor a checkout."""
    work = folder / "linked"
    work.mkdir()
    (work / "tree").symlink_to(mutate.ROOT / "sim")
    check(ends(mutate.Copy, work, ("sim",)), "a link to the tree passes for a copy")
    checkout = folder / "checkout"
    (checkout / "tree/.git").mkdir(parents=True)
    check(ends(mutate.Copy, checkout, ("sim",)), "a checkout passes for a copy")
    check_restored(mutate.Copy(folder / "restored", ("sim",)))
    copy = mutate.Copy(folder / "work", ("sim",))
    (copy.tree / "sim").mkdir(parents=True)
    source = (mutate.ROOT / "sim/waveforms.h").read_bytes()
    (copy.tree / "sim/waveforms.h").symlink_to(mutate.ROOT / "sim/waveforms.h")
    check(ends(copy.write, "sim/waveforms.h", "fault"), "a link into the tree is written to")
    copy.tree = mutate.ROOT
    check(ends(copy.write, "sim/waveforms.h", source.decode()), "the tree is written to")
    check((mutate.ROOT / "sim/waveforms.h").read_bytes() == source, "the tree has changed")


def check_restored(copy):
    """A copy has the tree's files and bytes again, whatever was changed, added or lost there."""
    copy.restore()
    copy.write("sim/waveforms.h", "fault")
    (copy.tree / "sim/further.cc").write_text("fault")
    (copy.tree / "sim/skin/skin.h").unlink()
    copy.restore()
    names = mutate.files_of(mutate.ROOT)
    check(len(names) > 500 and mutate.files_of(copy.tree) == names, "other files than the tree's")
    wrong = [name for name in names if (copy.tree / name).read_bytes() != (mutate.ROOT / name).read_bytes()]
    check(not wrong, f"not restored: {wrong}")


def check_report(folder):
    """Status 1 while a survivor has no verdict or less than 92 % are caught; the last row of a fault counts.

    What is equivalent is not counted, what another test finds is caught.
    """
    row = {"file": "sim/a.cc", "line": 1, "column": 1, "kind": "sign", "after": "", "test": "", "seconds": 1}
    results = folder / "results.jsonl"
    verdicts = folder / "mutants.toml"
    mutate.VERDICTS = verdicts

    def status(survivors, explained, verdict):
        rows = [row | {"before": f"a{i};", "verdict": "survived" if i < survivors else "caught"} for i in range(25)]
        first = row | {"before": "a24;", "verdict": "survived"}
        results.write_text("".join(json.dumps(each) + "\n" for each in [first, *rows]) + '{"cut', encoding="utf-8")
        verdicts.write_text("".join(
            f'[[fault]]\nfile = "sim/a.cc"\nkind = "sign"\nbefore = "a{i};"\nafter = ""\nverdict = "{verdict}"\n'
            for i in range(explained)), encoding="utf-8")
        with contextlib.redirect_stdout(io.StringIO()):
            return mutate.report(types.SimpleNamespace(results=results))

    tested = [status(count, explained, "A.B") for count, explained in ((0, 0), (1, 0), (1, 1), (2, 2), (3, 3))]
    check(tested == [0, 1, 0, 0, 1], f"the report's status: {tested}")
    check(status(3, 3, "equivalent: so") == 0, "what is equivalent counts")
    check(status(3, 3, "found by A.B") == 0, "what another test finds is not caught")


def check_first_failure():
    passed = "[ RUN      ] A.B\n[       OK ] A.B (0 ms)\n[ RUN      ] C/D.E/3\n"
    skipped = "[ RUN      ] F.G\n[  SKIPPED ] F.G (0 ms)\n"
    for end in (" (5 ms)", ", where GetParam() = 4 (5 ms)"):
        check(mutate.first_failure(passed + f"[  FAILED  ] C/D.E/3{end}\n" + skipped) == "C/D.E/3", "a failed test")
    check(mutate.first_failure(passed) == "C/D.E/3" and mutate.first_failure("") == "does not start", "a crash")


check_faults()
check_first_failure()
check_choice()
check(mutate.VERDICTS.exists(), "no verdicts")
with tempfile.TemporaryDirectory() as name:
    check_copy(pathlib.Path(name).resolve())
    check_report(pathlib.Path(name))
