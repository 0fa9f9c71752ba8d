#!/usr/bin/env python3
"""Lines of base, trial, acquire, dsp, sim and fit that their own tests run.

    tests/long/coverage.py [--lines FILE] [--without-build]

Builds the rooms and their tests by clang++ with its counters in build/coverage, runs each test program
whole, the pinned numbers of every verb and the number tables of other programs, and prints for each room
the share of its lines that were run, and for all. --lines writes the lines that were not: file, line, text.
Needs llvm-cov-19 and llvm-profdata-19.
"""
import argparse
import collections
import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "coverage"
ROOMS = ["base", "trial", "acquire", "dsp", "sim", "fit"]
LEAST = 0.92
TEST_S = 3000
VERBS = "bin/haptometer"
SCRIPTS = [["tests/golden/golden.py", "--check"], ["tests/trial/number_tables_test.py"]]


def build():
    """Configures and builds; returns the test programs of the rooms."""
    counters = "-fprofile-instr-generate -fcoverage-mapping"
    subprocess.run(["cmake", "-S", ROOT, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                    "-DCMAKE_CXX_COMPILER=clang++-19", f"-DCMAKE_CXX_FLAGS={counters} -ffp-contract=off",
                    "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -g0", "-DHAPTOMETER_JOIN_SOURCES=ON"],
                   check=True, stdout=subprocess.DEVNULL)
    listed = subprocess.run(["ninja", "-C", BUILD, "-t", "targets", "all"], check=True, capture_output=True,
                            text=True).stdout
    names = [line.split(":")[0] for line in listed.splitlines()]
    programs = sorted({name for name in names if name.startswith("bin/") and name.endswith("_test")
                       and name[4:].split("_")[0] in [*ROOMS, "hard"]})
    subprocess.run(["ninja", "-C", BUILD, *programs, VERBS], check=True, stdout=subprocess.DEVNULL)
    return programs


def run(programs):
    """Runs each program once; the merged counters."""
    commands = [[BUILD / program, "--gtest_brief=1"] for program in programs]
    commands += [["/usr/bin/python3", *script] for script in SCRIPTS]
    for command in commands:
        counts = {**os.environ, "LLVM_PROFILE_FILE": str(BUILD / "counts" / "%8m.profraw"), "HAPTOMETER_CACHE": "off",
                  "HAPTOMETER_PROGRAMS": str(BUILD / "bin")}
        done = subprocess.run(command, env=counts, cwd=ROOT, capture_output=True, text=True, timeout=TEST_S)
        print(f"{' '.join(map(str, command))}: status {done.returncode}", flush=True)
    merged = BUILD / "counts.profdata"
    raw = sorted((BUILD / "counts").glob("*.profraw"))
    subprocess.run(["llvm-profdata-19", "merge", "-o", merged, *raw], check=True)
    return merged


def lines_of(programs, merged):
    """How often each line of the rooms was run, by file: lines without code are not among them."""
    first, *others = (str(BUILD / program) for program in [*programs, VERBS])
    objects = [first, *(word for program in others for word in ("-object", program))]
    exported = subprocess.run(["llvm-cov-19", "export", "-format=lcov", f"-instr-profile={merged}", *objects,
                               *(str(ROOT / room) for room in ROOMS)], check=True, capture_output=True, text=True).stdout
    counts = collections.defaultdict(dict)
    for line in exported.splitlines():
        if line.startswith("SF:"):
            path = pathlib.Path(line[3:]).resolve().relative_to(ROOT)
        if line.startswith("DA:"):
            place, count = line[3:].split(",")[:2]
            counts[path][int(place)] = max(int(count), counts[path].get(int(place), 0))
    return counts


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--lines", type=pathlib.Path)
    parser.add_argument("--without-build", action="store_true", help="of the counters that are there")
    options = parser.parse_args()
    names = BUILD / "programs.json"
    if not options.without_build:
        programs = build()
        names.write_text(json.dumps(programs), encoding="utf-8")
        run(programs)
    counts = lines_of(json.loads(names.read_text(encoding="utf-8")), BUILD / "counts.profdata")
    total = collections.Counter()
    for path, lines in counts.items():
        for room in (path.parts[0], "all"):
            total[room, "lines"] += len(lines)
            total[room, "run"] += sum(count > 0 for count in lines.values())
    for room in [*ROOMS, "all"]:
        print(f"{room}: {total[room, 'run']} of {total[room, 'lines']} lines, {total[room, 'run'] / total[room, 'lines']:.1%}")
    if options.lines:
        with options.lines.open("w", encoding="utf-8") as file:
            for path, lines in sorted(counts.items()):
                text = (ROOT / path).read_text(encoding="utf-8").splitlines()
                file.writelines(f"{path}:{place}: {text[place - 1]}\n" for place, count in sorted(lines.items()) if count == 0)
    return 0 if total["all", "run"] >= LEAST * total["all", "lines"] else 1


if __name__ == "__main__":
    sys.exit(main())
