#!/usr/bin/env python3
"""The rooms on AArch64: cross built against Debian's arm64 packages, their tests run by qemu's user emulation.

    tests/long/arm64.py --sysroot              unpacks the packages into build/arm64-sysroot, for the preset arm64
    tests/long/arm64.py                        does so where they are missing, builds the test programs, runs them, prints
                                               passed, failed and skipped cases of each, and writes a column of
                                               docs/developer/hard_cases.md
    tests/long/arm64.py --programs NAME...     these alone

Needs the group arm64 of tools/packages.txt. The machine's own packages stay as they are.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

import hard_cases

ROOT = pathlib.Path(__file__).resolve().parents[2]
SYSROOT = ROOT / "build" / "arm64-sysroot"
LIBRARIES = SYSROOT / "usr" / "lib" / "aarch64-linux-gnu"
BUILD = ROOT / "build" / "arm64"
JOBS = 2
# several processes share the cases of a long program
SHARDS = 4
PROGRAMS = ["base_test", "trial_test", "dsp_analysis_test", "dsp_filter_test", "dsp_readings_test", "dsp_spectrum_test",
            "dsp_statistics_test", "sim_test", "fit_test"]
# cases that cannot run under user emulation, and why
LEFT_OUT = {}


def packages():
    """The libraries of the group build, and the C library."""
    lines = (ROOT / "tools" / "packages.txt").read_text(encoding="utf-8").splitlines()
    groups = [line.split() for line in lines if line and not line.startswith("#")]
    return ["libc6-dev", *(name for group, name in groups if group == "build" and name.endswith("-dev"))]


def linked_within(libraries):
    """Packages state some links and libraries from the root of the system, which here is SYSROOT."""
    for path in libraries.glob("*.so*"):
        if path.is_symlink() and os.path.isabs(os.readlink(path)):
            target = SYSROOT / os.readlink(path).lstrip("/")
            path.unlink()
            path.symlink_to(os.path.relpath(target, path.parent))
    for path in libraries.glob("cmake/*/*.cmake"):
        text = path.read_text(encoding="utf-8")
        path.write_text(re.sub(r"(?<![\w}])/usr/lib/aarch64-linux-gnu(?=/lib[\w.+-]+\.so)", str(libraries), text),
                        encoding="utf-8")


def alternatives_chosen(libraries):
    """What update-alternatives would do if the packages were configured: BLAS and LAPACK of the first one that is there."""
    for folder in ("atlas", "blas", "lapack"):
        for path in sorted((libraries / folder).glob("lib*")):
            link = libraries / path.name
            if not link.is_symlink() and not link.exists():
                link.symlink_to(f"{folder}/{path.name}")


def unpack():
    """Makes the sysroot, unless it has these packages, and in this place."""
    listed = SYSROOT / "packages"
    names = "\n".join([str(SYSROOT), *packages()])
    if listed.exists() and listed.read_text(encoding="utf-8") == names:
        return
    shutil.rmtree(SYSROOT, ignore_errors=True)
    SYSROOT.parent.mkdir(exist_ok=True)
    subprocess.run(["mmdebstrap", "--quiet", "--variant=extract", "--architectures=arm64",
                    f"--include={','.join(packages())}", "bookworm", SYSROOT], check=True)
    linked_within(LIBRARIES)
    alternatives_chosen(LIBRARIES)
    listed.write_text(names, encoding="utf-8")


def build(programs):
    subprocess.run(["cmake", "--preset", "arm64"], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", BUILD, "--parallel", str(JOBS), "--target", *programs], check=True,
                   stdout=subprocess.DEVNULL)


def emulated(program):
    return ["qemu-aarch64-static", "-L", str(SYSROOT), str(BUILD / "bin" / program)]


def run_shard(program, shard):
    """What GoogleTest reports of one of SHARDS processes; None if it ended without a report."""
    with tempfile.TemporaryDirectory() as folder:
        report = os.path.join(folder, "report.json")
        environment = {**os.environ, "GTEST_TOTAL_SHARDS": str(SHARDS), "GTEST_SHARD_INDEX": str(shard)}
        done = subprocess.run([*emulated(program), f"--gtest_output=json:{report}", "--gtest_brief=1",
                               f"--gtest_filter=-{':'.join(LEFT_OUT)}"], env=environment, cwd=ROOT, check=False,
                              capture_output=True, text=True)
        if done.returncode != 0:
            print(done.stdout[-8000:], done.stderr[-2000:], sep="\n", file=sys.stderr)
        if not os.path.exists(report):
            return None
        with open(report, encoding="utf-8") as file:
            return json.load(file)


def counted(reports):
    """Passed, failed and skipped cases; a process without a report counts as one failure."""
    cases = [case for report in reports if report is not None for suite in report["testsuites"]
             for case in suite["testsuite"] if case["status"] == "RUN"]
    failed = sum("failures" in case for case in cases)
    skipped = sum(case["result"] == "SKIPPED" for case in cases)
    return len(cases) - failed - skipped, failed + reports.count(None), skipped


def run(programs):
    """Runs the programs and prints a line for each; returns how many cases failed."""
    total = 0
    with concurrent.futures.ThreadPoolExecutor(JOBS) as pool:
        for program in programs:
            begun = time.monotonic()
            reports = list(pool.map(run_shard, [program] * SHARDS, range(SHARDS)))
            passed, failed, skipped = counted(reports)
            print(f"{program}: {passed} passed, {failed} failed, {skipped} skipped, {time.monotonic() - begun:.0f} s",
                  flush=True)
            total += failed
    return total


def hard_case_column():
    """Writes the column of the page; returns how many cases miss their bar."""
    rows = hard_cases.rows_of(emulated("hard_cases_test"))
    hard_cases.write_emulated(rows)
    missed = [row for row in rows if "missed" in hard_cases.digits(row)]
    for row in missed:
        print(f"hard case missed: {row['name']}: error {row['error']}, bar {row['bar']}")
    print(f"hard cases: {len(rows) - len(missed)} hold, {len(missed)} missed")
    return len(missed)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--sysroot", action="store_true")
    parser.add_argument("--programs", nargs="*", choices=[*PROGRAMS, "hard_cases_test"],
                        default=[*PROGRAMS, "hard_cases_test"])
    given = parser.parse_args()
    unpack()
    if given.sysroot:
        return 0
    build(given.programs)
    for name, reason in LEFT_OUT.items():
        print(f"left out: {name}: {reason}")
    failed = run([name for name in given.programs if name != "hard_cases_test"])
    if "hard_cases_test" in given.programs:
        failed += hard_case_column()
    return 0 if failed == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
