#!/usr/bin/python3
"""Zero-phase filtering of 25 million samples, N = 4, beside SciPy's sosfiltfilt in the same run.

  zero_phase_rate.py build/release/bin [--samples 25000000] [--rounds 7] [--plain-malloc]

Each round times one call of each in turn; the best of all rounds counts. Both sides have touched their
memory before. The gain of two threads is measured by itself: in each round one and two of the filter and of
the bare loop, all four in turn, three times. malloc is told to keep SciPy's work space from call to call, more than a user does;
--plain-malloc leaves it as it is in any program.
"""
import argparse
import ctypes
import math
import pathlib
import subprocess
import time

try:
    import numpy as np
    from scipy import signal
except ImportError:
    print("needs SciPy (python3-scipy)")
    raise SystemExit(77)


def keep_memory():
    libc = ctypes.CDLL("libc.so.6")
    libc.mallopt(-4, 0)              # M_MMAP_MAX: everything comes from the heap,
    libc.mallopt(-1, (1 << 31) - 1)  # M_TRIM_THRESHOLD: which is never given back


class Program:
    def __init__(self, path, *arguments):
        self.process = subprocess.Popen([path, *map(str, arguments)], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, text=True, bufsize=1)

    def seconds(self, command):
        self.process.stdin.write(command + "\n")
        self.process.stdin.flush()
        return float(self.process.stdout.readline())


def known_sets():
    flags = pathlib.Path("/proc/cpuinfo").read_text()
    return ["sse2"] + [s for s, flag in (("avx2", "avx2"), ("avx512", "avx512dq")) if flag in flags]


def compare(programs, samples, rate, rounds):
    program = Program(pathlib.Path(programs) / "zero_phase_rate", samples, rate, 4)
    sos = signal.butter(4, [20, 500], "band", fs=rate, output="sos")
    record = 0.03 + 1e-6 * np.sin(0.063 * np.arange(samples))
    commands = [f"filter {s} 1" for s in known_sets()]
    widest = known_sets()[-1]
    commands += [f"filter {widest} 2", "memcpy"]
    one_and_two = [f"filter {widest} 1", f"filter {widest} 2", "loop 1", "loop 2"]
    best = {}
    paired = {}
    for _ in range(rounds + 1):   # the first round warms up
        start = time.perf_counter()
        signal.sosfiltfilt(sos, record)
        times = {"sosfiltfilt": time.perf_counter() - start}
        times.update({command: program.seconds(command) for command in commands})
        best = {name: min(seconds, best.get(name, seconds)) for name, seconds in times.items()}
        for command in one_and_two * 3:
            paired[command] = min(program.seconds(command), paired.get(command, math.inf))
    program.process.stdin.close()
    program.process.wait()
    for name in ["sosfiltfilt", *commands]:
        print(f"{rate / 1e3:6g} kHz  {name:18} {samples / best[name] / 1e6:7.1f} million samples/s  "
              f"{best['sosfiltfilt'] / best[name]:6.2f} x SciPy")
    one, two, bare_one, bare_two = (paired[command] for command in one_and_two)
    gain = one / two
    bare = 2 * bare_one / bare_two
    print(f"{rate / 1e3:6g} kHz  two threads: {gain:.2f} times one; two bare loops {bare:.2f}; "
          f"ratio {gain / bare:.2f}", flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("programs")
    parser.add_argument("--samples", type=int, default=25_000_000)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--plain-malloc", action="store_true")
    arguments = parser.parse_args()
    if not arguments.plain_malloc:
        keep_memory()
    for rate in (10e3, 392e3):
        compare(arguments.programs, arguments.samples, rate, arguments.rounds)


main()
