#!/usr/bin/env python3
"""The way from a calibration to the budget of analyze, for many rigs: each is calibrated by pairs with noise, records a
sine through that calibration, and is analysed. How often the 95 % interval of the RMS holds the true one.

    tests/long/calibration_budget.py PROGRAMS [SEEDS]
    haptometer campaign plan budget --ending json -- tests/long/calibration_budget.py PROGRAMS SEEDS
                                                  the same in chunks (docs/reference/campaign.md)

The gain's error is what the noise of the pairs makes of it, some 0.5 %, so it dominates the budget. Status 1 where the
share lies outside 93 to 97 %.
"""
import argparse
import concurrent.futures
import json
import math
import os
import pathlib
import random
import subprocess
import sys
import tempfile

GAIN_M_PER_V = 1e-3
NOISE_V = 30e-3  # of a pair's voltage: 0.4 % of the slope of 9 points over +-4 V
AMPLITUDE_M = 50e-6
RATE_HZ, TONE_HZ, LENGTH_S = 2000, 150, 1.5
DEADLINE_S = 120


def run(programs, *words):
    done = subprocess.run([os.path.join(programs, words[0]), *words[1:]], capture_output=True, text=True,
                          timeout=DEADLINE_S, check=False)
    if done.returncode not in (0, 3):
        raise RuntimeError(f"{words}: {done.stderr}")
    return done.stdout


def rig(programs, seed):
    """(Whether the interval holds the true RMS, relative standard uncertainty of the gain)."""
    draw = random.Random(seed)
    with tempfile.TemporaryDirectory() as folder:
        pairs, calibration, table = (os.path.join(folder, name) for name in ("pairs.csv", "c.toml", "daq.csv"))
        rows = [(mm, mm * 1e-3 / GAIN_M_PER_V + draw.gauss(0, NOISE_V)) for mm in range(-4, 5)]
        pathlib.Path(pairs).write_text("displacement_mm,voltage_v\n" + "".join(f"{mm},{v:.6f}\n" for mm, v in rows),
                                       encoding="utf-8")
        run(programs, "haptometer", "calibrate", pairs, "--averaging", "1", "-o", calibration)
        phase, step = draw.uniform(0, 2 * math.pi), 2 * math.pi * TONE_HZ / RATE_HZ
        volts = [(AMPLITUDE_M * math.sin(phase + step * n)) / GAIN_M_PER_V + draw.gauss(0, 2e-4)
                 for n in range(int(RATE_HZ * LENGTH_S))]
        pathlib.Path(table).write_text("time_s,sensor\n" + "".join(f"{n / RATE_HZ:.4f},{v:.7f}\n"
                                                                   for n, v in enumerate(volts)), encoding="utf-8")
        answer = json.loads(run(programs, "analyze", table, "--calibration", calibration, "--window", "all", "--json"))
    trial = answer["trials"][0]
    if not trial["answered"]:
        raise RuntimeError(f"seed {seed}: {trial['reasons']}")
    lower, upper = trial["band_rms_interval_95_m"]
    return lower <= AMPLITUDE_M / math.sqrt(2) <= upper, trial["calibration_relative_standard_uncertainty"]


def rigs(programs, seeds):
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(lambda seed: rig(programs, seed), seeds))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("programs")
    parser.add_argument("seeds", nargs="?", type=int, default=1000)
    parser.add_argument("--shard", default="1/1")
    parser.add_argument("-o", dest="part", help="the results of a shard")
    parser.add_argument("--resume", action="store_true", help="a shard is short, and begins anew")
    parser.add_argument("--merge", nargs="+", default=[], help="the results of all shards")
    given = parser.parse_args()
    number, count = map(int, given.shard.split("/"))
    if given.merge:
        parts = [json.loads(pathlib.Path(path).read_text(encoding="utf-8")) for path in given.merge]
        results = [parts[seed % len(parts)][seed // len(parts)] for seed in range(given.seeds)]
    else:
        results = rigs(given.programs, range(number - 1, given.seeds, count))
    if given.part:
        pathlib.Path(given.part).write_text(json.dumps(results), encoding="utf-8")
        return
    report(results)


def report(results):
    held, seeds = sum(holds for holds, _ in results), len(results)
    shares = sorted(share for _, share in results)
    print(f"{held} of {seeds} intervals hold the true RMS: {100 * held / seeds:.1f} %; relative standard uncertainty of "
          f"the gain {100 * shares[0]:.2f} to {100 * shares[-1]:.2f} %, median {100 * shares[seeds // 2]:.2f} %")
    # three standard deviations of a binomial beside the bar, for fewer seeds
    slack = 3 * math.sqrt(0.05 * 0.95 / seeds) if seeds < 1000 else 0
    sys.exit(0 if 0.93 - slack <= held / seeds <= 0.97 + slack else 1)


if __name__ == "__main__":
    main()
