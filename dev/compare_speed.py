#!/usr/bin/env python3
"""Compares two builds: the rows of the benches and whole commands, in interleaved pairs.

  /usr/bin/python3 dev/compare_speed.py OLD_BIN NEW_BIN [PAIRS]

Prints for each row the median over PAIRS (21) of new over old. A pair runs the old and the new program one after the
other, in turn which comes first, so that a machine that becomes slower changes both. Rows above 1.05 are marked.
"""
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time

BENCHES = ["adapter_tuning_bench", "emulator_bench", "exact_step_bench", "filter_bench", "import_bench", "live_meter_bench",
           "modbus_rate_bench", "piecewise_bench", "protocol_bench", "ring_down_fit_bench", "smooth_bench",
           "spectrum_bench", "trial_write_read_bench"]
# a command's words; t.bin holds 10 s of readings
COMMANDS = [
    ["analyze", "t.bin", "--json"],
    ["analyze", "fixtures/recorded_trial.bin", "--json"],
    ["fit-lra", "fixtures/impulse.csv", "--moving-mass", "1.4g", "--json"],
    ["simulate", "fixtures/lra_adapter.toml", "--json"],
    ["simulate", "fixtures/lra_stops.toml", "--duration", "0.5s", "--json"],
    ["tune", "--json"],
    ["sweep", "fixtures/lra_adapter.toml", "--vary", "drive.frequency_hz=200:250:501", "-o", "OUT.csv", "--overwrite"],
    ["trial", "info", "t.bin", "--json"],
    ["trial", "export", "t.bin", "-o", "OUT.csv", "--overwrite"],
    ["reproduce", "--json"],
]
LIMIT = 1.05
LEAST_S = 0.02  # of a bench's row
DEADLINE_S = 600


def output_of(words):
    return subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, timeout=DEADLINE_S).stdout


def bench_rows(program):
    """The time of each row of a bench."""
    text = output_of([program, f"--benchmark_min_time={LEAST_S}", "--benchmark_format=json"])
    return {row["name"]: row["real_time"] for row in json.loads(text)["benchmarks"] if "real_time" in row}


def command_rows(folder, words, scratch):
    """The time of one command, with files of its own."""
    words = [f"{scratch}/{word}" if word in ("t.bin", "OUT.csv") else word for word in words]
    begin = time.perf_counter()
    output_of([f"{folder}/haptometer", *words])
    return {"haptometer " + " ".join(os.path.basename(word) for word in words): time.perf_counter() - begin}


def compared(pairs, run_old, run_new):
    """The ratios of each row."""
    ratios = {}
    for pair in range(pairs):
        order = [run_old, run_new] if pair % 2 == 0 else [run_new, run_old]
        first, second = order[0](), order[1]()
        old, new = (first, second) if pair % 2 == 0 else (second, first)
        for name in old.keys() & new.keys():
            ratios.setdefault(name, []).append(new[name] / old[name])
    return ratios


def show(ratios):
    slower = 0
    for name, values in sorted(ratios.items()):
        median = statistics.median(values)
        slower += median > LIMIT
        print(f"{median:7.3f} {'slower' if median > LIMIT else '      '} {name}", flush=True)
    return slower


def main():
    old, new = (os.path.abspath(folder) for folder in sys.argv[1:3])
    pairs = int(sys.argv[3]) if len(sys.argv) > 3 else 21
    slower = 0
    with tempfile.TemporaryDirectory() as scratch:
        made = [f"{new}/haptometer", "simulate", "fixtures/lra_adapter.toml", "--duration", "10s", "-o", f"{scratch}/t.bin"]
        subprocess.run(made, check=True, stdout=subprocess.DEVNULL)
        for words in COMMANDS:
            slower += show(compared(pairs, lambda: command_rows(old, words, scratch),
                                    lambda: command_rows(new, words, scratch)))
    for name in BENCHES:
        slower += show(compared(pairs, lambda: bench_rows(f"{old}/{name}"), lambda: bench_rows(f"{new}/{name}")))
    print(f"{slower} rows slower by more than {100 * (LIMIT - 1):.0f} %")


if __name__ == "__main__":
    main()
