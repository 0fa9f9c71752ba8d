#!/usr/bin/env python3
"""What a second worker gains a sweep, beside what a second process gains it, in the same run.

  /usr/bin/python3 tests/long/sweep_rate.py build/release/bin [--scene FILE] [--points 1000] [--rounds 7]

Without --scene the thesis's adapter scene with travel stops at 0.5 mm, reached around the resonance only, so that
points take from 2 to 5 ms; a linear one is --scene fixtures/lra_adapter.toml. Four ways of the same sweep in
alternation, by the clock: one process with one thread; one with two threads; two processes with one thread and half
of the points each (--shard), started together; and one thread without the work, `--resume` of the finished table,
which is what all the rest costs. Tables are compared byte for byte but for their provenance, the shards' after
--merge. Gain: the time of one thread over that of two. The bar: two workers gain at least 0.9 of what two processes
gain. Medians over the rounds; beside other work the machine's second core is not there to be gained, and both gains
fall together.
"""
import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time

STOPS = """
[effects]
travel_stops = true
[travel_stops]
stiffness_n_per_m = 1e6
damping_n_s_per_m = 1
gap_m = 0.5e-3
"""


def begin(program, question, table, *more):
    return subprocess.Popen([program, "sweep", *question, "-o", table, *more], stdout=subprocess.DEVNULL)


def timed(*processes_of):
    """Seconds until all are done that the calls start."""
    began = time.perf_counter()
    for process in [call() for call in processes_of]:
        if process.wait() != 0:
            sys.exit(f"{process.args} ends with {process.returncode}")
    return time.perf_counter() - began


def content(path):
    with open(path, "rb") as file:
        return file.read()


def rows_of(path):
    """A table without the lines of when and by which command it was made."""
    return [line for line in content(path).splitlines() if not line.startswith(b"# provenance")]


def scene_with_stops(folder):
    path = os.path.join(folder, "stops.toml")
    with open(path, "wb") as file:
        file.write(content("fixtures/lra_adapter.toml") + STOPS.encode())
    return path


def measure(program, question, folder, rounds):
    path = lambda name: os.path.join(folder, name)
    go = lambda name, *more: lambda: begin(program, question, path(name), *more)
    one = ("--threads", "1", "--overwrite")
    ways = {
        "one thread": [go("one.csv", *one)],
        "two threads": [go("two.csv", "--threads", "2", "--overwrite")],
        "two processes": [go("s1.csv", *one, "--shard", "1/2"), go("s2.csv", *one, "--shard", "2/2")],
        "nothing to do": [go("one.csv", "--threads", "1", "--resume")],
    }
    times_s = {name: [] for name in ways}
    for _ in range(rounds):
        for name, calls in ways.items():
            times_s[name].append(timed(*calls))
    subprocess.run([program, "sweep", "--merge", path("s1.csv"), path("s2.csv"), "-o", path("merged.csv")],
                   check=True, stdout=subprocess.DEVNULL)
    whole = rows_of(path("one.csv"))
    for name in ("two.csv", "merged.csv"):
        if rows_of(path(name)) != whole:
            sys.exit(f"{name} differs from one thread's table")
    return times_s


def report(times_s, points):
    medians = {name: statistics.median(all_) for name, all_ in times_s.items()}
    for name, all_ in times_s.items():
        print(f"{name:14} median {medians[name]:7.3f} s, best {min(all_):7.3f} s "
              f"({1e6 * medians[name] / points:.1f} us a point)")
    gains = {}
    for name in ("two threads", "two processes"):
        # of the same round, so that what else runs then weighs on both
        gains[name] = statistics.median(a / b for a, b in zip(times_s["one thread"], times_s[name]))
        print(f"gain of {name}: {gains[name]:.3f}")
    share = statistics.median(p / t for p, t in zip(times_s["two processes"], times_s["two threads"]))
    print(f"two workers gain {share:.3f} of what two processes gain (bar 0.9), best against best "
          f"{min(times_s['two processes']) / min(times_s['two threads']):.3f}")
    return share >= 0.9


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("programs")
    parser.add_argument("--scene")
    parser.add_argument("--points", type=int, default=1000)
    parser.add_argument("--duration", default="0.1s", help="of each point's run")
    parser.add_argument("--rounds", type=int, default=7)
    arguments = parser.parse_args()
    program = os.path.join(arguments.programs, "haptometer")
    vary = ["--vary", f"drive.frequency_hz=100Hz:400Hz:{arguments.points}", "--vary",
            f"run.duration_s={arguments.duration}"]
    with tempfile.TemporaryDirectory() as folder:
        scene = arguments.scene or scene_with_stops(folder)
        good = report(measure(program, [scene, *vary], folder, arguments.rounds), arguments.points)
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
