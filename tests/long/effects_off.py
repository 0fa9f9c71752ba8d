#!/usr/bin/python3
"""What effects cost that a scene does not call for, in instructions counted by callgrind.

  effects_off.py build/release/bin [--outputs 1000000]

The thesis's adapter scene at 10 kHz: by the engine with every effect there and off, and by a plain loop
over the same step's matrix (bench/effects_off_cost.cc); then both with all the waveforms of
`simulate --waveforms`. The cost of an output is the difference of two runs, N and 2 N outputs, so that
set-up cancels; set-up is told apart. Status 1 if an output costs over 1.02 of the plain loop's, or if
the two do not agree to the last bit over their first 16384 outputs. The build must be for x86-64 as it
is (presets release and dev): valgrind 3.19 does not know AVX-512.
"""
import argparse
import pathlib
import re
import shutil
import subprocess
import sys

BAR = 1.02


def instructions(program, way, outputs):
    run = subprocess.run(["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", program, way,
                          str(outputs)], capture_output=True, text=True, check=False)
    found = re.search(r"Collected : (\d+)", run.stderr)
    if run.returncode != 0 or not found:
        sys.exit(f"{way}: callgrind failed\n{run.stderr}")
    return int(found.group(1))


def last(program, way, outputs):
    return subprocess.run([program, way, str(outputs)], capture_output=True, text=True,
                          check=True).stdout


def main():
    options = argparse.ArgumentParser()
    options.add_argument("bin", type=pathlib.Path)
    options.add_argument("--outputs", type=int, default=1_000_000)
    options = options.parse_args()
    if not shutil.which("valgrind"):
        print("skipped: needs valgrind")
        return 77
    program = str(options.bin / "effects_off_cost")
    nothing = instructions(program, "none", 1)
    holds = True
    for bare, ways in (("bare", ("scene", "single")), ("bare-waves", ("waves",))):
        same = last(program, bare, 16000) == last(program, ways[0], 16000)
        print(f"{bare}, {ways[0]}: the same bits after 16000 outputs: {'yes' if same else 'NO'}")
        per_output = {}
        for way in (bare, *ways):
            once, twice = (instructions(program, way, n * options.outputs) for n in (1, 2))
            per_output[way] = (twice - once) / options.outputs
            setup = once - (twice - once) - nothing
            print(f"{way:10}: {per_output[way]:8.2f} instructions an output, "
                  f"{per_output[way] / per_output[bare]:.4f} of {bare}; set-up {setup}; "
                  f"{options.outputs} outputs with set-up {once - nothing}")
        ratio = per_output[ways[0]] / per_output[bare]
        print(f"every effect there and off: {100 * (ratio - 1):+.2f} % (bar {100 * (BAR - 1):.0f} %)")
        holds = holds and same and ratio <= BAR
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())
