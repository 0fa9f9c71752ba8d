#!/usr/bin/env python3
"""Lines of base, trial, acquire, dsp, sim and fit that tests run.

    tests/long/coverage.py [--lines FILE] [--branches FILE] [--page] [--without-build]

Builds the rooms and their tests by clang++ with its counters in build/coverage, runs each test program
whole, the pinned numbers of every verb and the number tables of other programs, and prints for each room
the share of its lines that were run, and for all. --lines writes the lines that were not: file, line, text;
--branches those with a condition of which one outcome never came, and which: there a comparison can be
reversed without any test failing. --page writes docs/developer/coverage.md, which says why. Needs
llvm-cov-19 and llvm-profdata-19.
"""
import argparse
import collections
import json
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "coverage"
ROOMS = ["base", "trial", "acquire", "dsp", "sim", "fit"]
LEAST = 0.92
TEST_S = 3000
VERBS = "bin/haptometer"
PAGE = ROOT / "docs" / "developer" / "coverage.md"
# why lines are not run: the first whose words stand in a stretch of them
REASONS = {
    "what only a real port, a USB adapter, another program or a lost connection does; tests/system does a part of it in "
    "whole programs":
        r"LatencyTimer|LowLatency|LOW_LATENCY|connection was lost|interrupted before|vendor|IsHardware|recv\("
        r"|modbus_get_socket|SleepUntil|CommandPipe|PlainPort|posix_spawn|[Ii]dentity|is_emulated_|ReadAnalog"
        r"|kAnalogError",
    "what the system or a library fails at (disk, memory, descriptors), which no test brings about":
        r"errno|strerror|Reason\(|NotWritten|sp_last_error|gai_strerror|Broken\(|could not be|too many files|NoTerminal"
        r"|cannot be (locked|listed|opened|replaced|set)",
    "refusals of files and of stated values that no test states; each is a message and a return":
        r"CannotAnswer|Usage\(|Wrong\(|Refuse\(|->Fail\(|^return \"|Unfit\(|NoNumber|std::unexpected|no_ring_down ="
        r"|error\.what|return std::nullopt",
    "programming errors: checks that no caller fails, values of a switch that do not occur":
        r"HAPTOMETER_CHECK|CheckFailed|BelowRoot|default:|^return (text\.size\(\)|model\.skin\(\)|kWords\.front\(\));$",
    "kernels of instruction sets that this processor does not need": r"InstructionSet",
    "findings that no test's record has; each is its numbers":
        r"\b(Note|Doubt|Add|note)\(|FindingKind::|NoRun\(|Refused\(|Reject\(",
}
REST = "rare branches: dialects of tables, shapes of records and scenes that nothing of these runs meets"
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


def exported(programs, merged):
    """What llvm-cov has of each file of the rooms: pairs of its path and a line of lcov."""
    first, *others = (str(BUILD / program) for program in [*programs, VERBS])
    objects = [first, *(word for program in others for word in ("-object", program))]
    said = subprocess.run(["llvm-cov-19", "export", "-format=lcov", f"-instr-profile={merged}", *objects,
                           *(str(ROOT / room) for room in ROOMS)], check=True, capture_output=True, text=True).stdout
    for line in said.splitlines():
        if line.startswith("SF:"):
            path = pathlib.Path(line[3:]).resolve().relative_to(ROOT)
        else:
            yield path, line


def lines_of(rows):
    """How often each line was run, by file: lines without code are not among them."""
    counts = collections.defaultdict(dict)
    for path, line in rows:
        if line.startswith("DA:"):
            place, count = line[3:].split(",")[:2]
            counts[path][int(place)] = max(int(count), counts[path].get(int(place), 0))
    return counts


def outcomes_of(rows):
    """How often each outcome of each condition came, by file, line, condition and side (0 is true)."""
    counts = collections.defaultdict(dict)
    for path, line in rows:
        if line.startswith("BRDA:"):
            place, condition, side, count = line[5:].split(",")
            key = int(place), condition, int(side) % 2
            counts[path][key] = max(int(count.replace("-", "0")), counts[path].get(key, 0))
    return counts


def write_branches(file, outcomes):
    """The lines with an outcome that never came; those that only pass an error on are not among them."""
    with file.open("w", encoding="utf-8") as out:
        for path, counts in sorted(outcomes.items()):
            text = (ROOT / path).read_text(encoding="utf-8").splitlines()
            sides = collections.defaultdict(set)
            for (place, _, side), count in counts.items():
                if count == 0 and not re.search(r"HAPTOMETER_(TRY|LET|CHECK)", text[place - 1]):
                    sides[place].add(("true", "false")[side])
            out.writelines(f"{path}:{place}: never {' or '.join(sorted(never))}: {text[place - 1].strip()}\n"
                           for place, never in sorted(sides.items()))


def why(texts):
    """The reason of a stretch of lines that were not run."""
    text = "\n".join(texts)
    return next((reason for reason, words in REASONS.items() if re.search(words, text, re.MULTILINE)), REST)


def not_run(counts):
    """Lines that were not run, by reason and file; successive ones have one reason."""
    found = {reason: collections.Counter() for reason in [*REASONS, REST]}
    for path, lines in sorted(counts.items()):
        text = (ROOT / path).read_text(encoding="utf-8").splitlines()
        stretch = []
        for place in [*sorted(place for place, count in lines.items() if count == 0), None]:
            if stretch and place != stretch[-1] + 1:
                found[why([text[at - 1].strip() for at in stretch])][str(path)] += len(stretch)
                stretch = []
            stretch.append(place)
    return found


def write_page(counts, total):
    """Writes the page; rows of a table for the rooms, a list for each reason."""
    lines = ["# Lines that tests run", "",
             "Made by `tests/long/coverage.py --page`: the test programs of base to fit, the hard cases, the pinned numbers",
             "of every verb and the number tables of other programs, with clang's counters. Lines without code are not",
             "counted.", "",
             "| room | lines | run |", "|---|---|---|"]
    for room in [*ROOMS, "all"]:
        share = total[room, "run"] / total[room, "lines"]
        lines.append(f"| {room} | {total[room, 'lines']} | {share:.1%} |")
    lines += ["", "What is not run, and why (lines in brackets):", ""]
    for reason, files in not_run(counts).items():
        lines.append(f"- {sum(files.values())} lines: {reason}.")
        lines += [f"  - `{path}` ({count})" for path, count in files.most_common()]
    PAGE.write_text("\n".join(lines) + "\n", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--lines", type=pathlib.Path)
    parser.add_argument("--branches", type=pathlib.Path)
    parser.add_argument("--page", action="store_true", help=f"write {PAGE.relative_to(ROOT)}")
    parser.add_argument("--without-build", action="store_true", help="of the counters that are there")
    options = parser.parse_args()
    names = BUILD / "programs.json"
    if not options.without_build:
        programs = build()
        names.write_text(json.dumps(programs), encoding="utf-8")
        run(programs)
    rows = list(exported(json.loads(names.read_text(encoding="utf-8")), BUILD / "counts.profdata"))
    counts = lines_of(rows)
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
    if options.branches:
        write_branches(options.branches, outcomes_of(rows))
    if options.page:
        write_page(counts, total)
    return 0 if total["all", "run"] >= LEAST * total["all", "lines"] else 1


if __name__ == "__main__":
    sys.exit(main())
