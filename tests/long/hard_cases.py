#!/usr/bin/env python3
"""The page of hard cases (docs/developer/hard_cases.md), from what `hard_cases_test` prints in several builds.

    tests/long/hard_cases.py [--release PROGRAM] [--builds NAME...]
                                                   runs the release program, once more with each instruction set
                                                   that the processor has, then builds and runs each other build,
                                                   and writes the page after each; done builds are kept in
                                                   build/hard_cases, so that it may be begun again
    tests/long/hard_cases.py --check               the page has the cases of the program in HAPTOMETER_PROGRAMS,
                                                   with their reasons, naive methods, answers and bars
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "developer" / "hard_cases.md"
ROOMS = {"acquire": "recording", "trial": "files and times", "dsp": "filters and statistics", "sim": "motion",
         "fit": "constants"}
BASE = "-Wno-array-bounds -Wno-maybe-uninitialized"
# compiler and flags of each build; contraction joins a product and a sum to one rounding
BUILDS = {
    "g++ -O0": ("g++", "-O0 -ffp-contract=off"),
    "g++ -O3": ("g++", "-O3 -ffp-contract=off"),
    "g++ -O2 contracted": ("g++", "-O2 -mfma -ffp-contract=fast"),
    "clang++ -O0": ("clang++-19", "-O0 -ffp-contract=off"),
    "clang++ -O3": ("clang++-19", "-O3 -ffp-contract=off"),
}
# instruction sets of the release program's kernels, each with a flag of the processor that has it
SETS = {"sse2": "sse2", "avx2": "avx2", "avx512": "avx512dq"}
# the column that tests/long/arm64.py writes: g++ -O2 for AArch64, run by qemu's user emulation
EMULATED = "aarch64 under qemu"
HEAD = """# Hard cases

Made by `tests/long/hard_cases.py` from what `hard_cases_test` prints: each case runs a naive method too, and states
what that answers. Errors are relative, absolute where the truth is 0. Digits are -log10 of the error in each build;
`exact`: no error at all. A column is of the last run of its build, which may be of earlier sources; `not run`: not since
the case was added. `g++ -O2` is the release program; sse2, avx2 and
avx512 are its kernels with these instruction sets. Contracted: products and sums in one rounding. What ordinary tests
hold of hard cases is listed in [hard_case_tests.md](hard_case_tests.md).
"""


def rows_of(command, instruction_set=None):
    """What a program prints of its cases, in its order; it may miss bars, which the digits then show."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "rows")
        environment = {**os.environ, "HAPTOMETER_HARD_CASES": path}
        if instruction_set is not None:
            environment["HAPTOMETER_INSTRUCTION_SET"] = instruction_set
        subprocess.run(command, env=environment, check=False, stdout=subprocess.DEVNULL, timeout=3600)
        with open(path, encoding="utf-8") as file:
            return [json.loads(line) for line in file]


def built(name):
    """Configures and builds the program of a build, and returns its path."""
    compiler, flags = BUILDS[name]
    folder = ROOT / "build" / "hard_cases" / name.replace(" ", "_").replace("+", "x")
    subprocess.run(["cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                    f"-DCMAKE_CXX_COMPILER={compiler}", f"-DCMAKE_CXX_FLAGS={BASE}", f"-DCMAKE_CXX_FLAGS_RELEASE={flags}",
                    "-DHAPTOMETER_JOIN_SOURCES=ON"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", folder, "--target", "hard_cases_test", "--parallel", "2"], check=True,
                   stdout=subprocess.DEVNULL)
    return folder / "bin" / "hard_cases_test"


def known_sets():
    flags = pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8").split()
    return [name for name, flag in SETS.items() if flag in flags]


def number(value):
    return "not finite" if value is None else f"{value:.4g}"


def stated(row):
    """The cells that no build changes but in rounding: case, reason, naive method, bar."""
    bar = "exact" if row["bar"] == 0 else f"{row['bar']:.1e}"
    return [row["name"], row["why"], row["naive"], bar]


def answer(row):
    return f"{number(row['naive_value'])} (error {number(row['naive_error'])})"


def digits(row):
    if row["error"] is None:
        return "not finite (missed)"
    shown = "exact" if row["error"] == 0 else f"{row['digits']:.1f}"
    return shown if row["error"] <= row["bar"] else shown + " (missed)"


def line(cells):
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def page(rows_by_build):
    builds = list(rows_by_build)
    first = rows_by_build[builds[0]]
    text = [HEAD]
    for room, what in ROOMS.items():
        text.append(f"## {room}: {what}\n")
        text.append(line(["case", "why it is hard", "naive method", "its answer", "bar", *builds]))
        text.append("|" + "---|" * (5 + len(builds)))
        for place, row in enumerate(first):
            if row["room"] != room:
                continue
            name, why, naive, bar = stated(row)
            text.append(line([name, why, naive, answer(row), bar, *(digits(rows_by_build[b][place]) for b in builds)]))
        text.append("")
    return "\n".join(text)


def cells_of(entry):
    """The cells of a line of a table."""
    return [cell.strip().replace("\0", "|") for cell in entry.replace("\\|", "\0").strip("|").split("|")]


def rows_of_page(text):
    """Lines of a page, each with its room and its cells, which are None where it is not of a table."""
    room = None
    for entry in text.splitlines():
        if entry.startswith("## "):
            room = entry[3:].split(":")[0]
        yield entry, room, cells_of(entry) if entry.startswith("| ") else None


def column(text, build):
    """The cells of a build's column by room and case; none where the page has no such column."""
    found, place = {}, None
    for _, room, cells in rows_of_page(text):
        if cells is not None and cells[0] == "case":
            place = cells.index(build) if build in cells else None
        elif cells is not None and place is not None:
            found[room, cells[0]] = cells[place]
    return found


def with_column(text, build, shown):
    """The page's text with these cells, by room and case, as its last column."""
    lines, place = [], None
    for entry, room, cells in rows_of_page(text):
        if cells is not None and cells[0] == "case":
            place = cells.index(build) if build in cells else len(cells)
            entry = line([*cells[:place], build])
        elif cells is not None:
            entry = line([*cells[:place], shown.get((room, cells[0]), "not run")])
        elif entry.startswith("|---"):
            entry = "|" + "---|" * (place + 1)
        lines.append(entry)
    return "\n".join(lines) + "\n"


def write(rows_by_build):
    """Writes the page; the columns of builds that did not run now remain as they were."""
    before = PAGE.read_text(encoding="utf-8")
    text = page({first: rows for first, rows in list(rows_by_build.items())[:1]})
    for build in [*SETS, *BUILDS, EMULATED]:
        rows = rows_by_build.get(build)
        shown = column(before, build) if rows is None else {(row["room"], row["name"]): digits(row) for row in rows}
        if shown:
            text = with_column(text, build, shown)
    PAGE.write_text(text, encoding="utf-8")


def write_emulated(rows):
    """Writes the column of AArch64, the others remain as they were."""
    shown = {(row["room"], row["name"]): digits(row) for row in rows}
    PAGE.write_text(with_column(PAGE.read_text(encoding="utf-8"), EMULATED, shown), encoding="utf-8")


def check():
    """The page's rows are those of the program."""
    rows = rows_of(os.path.join(os.environ["HAPTOMETER_PROGRAMS"], "hard_cases_test"))
    text = PAGE.read_text(encoding="utf-8").splitlines()
    shown = [cells for cells in map(cells_of, filter(lambda entry: entry.startswith("| "), text)) if cells[0] != "case"]
    wanted = [stated(row) for room in ROOMS for row in rows if row["room"] == room]
    have = [cells[:3] + [cells[4]] for cells in shown]
    for row in wanted:
        if row not in have:
            print(f"FAILED: not on the page, or changed: {row}")
    for row in have:
        if row not in wanted:
            print(f"FAILED: on the page, but no case: {row}")
    print(f"{len(wanted)} cases")
    return 0 if have == wanted else 1


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--builds", nargs="*", choices=list(BUILDS), default=list(BUILDS))
    parser.add_argument("--release", default=ROOT / "build" / "release" / "bin" / "hard_cases_test")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    if given.check:
        return check()
    rows = {"g++ -O2": rows_of(given.release)}
    for name in known_sets():
        rows[name] = rows_of(given.release, name)
    write(rows)
    for name in given.builds:
        print(name, flush=True)
        rows[name] = rows_of(built(name))
        write(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
