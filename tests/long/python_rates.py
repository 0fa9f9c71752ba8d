"""What the Python package costs, as ratios within one run.

    python_rates.py [--samples 25000000] [--trials 96] [--rounds 5]

Run by a Python that has the package (python/install VENV; VENV/bin/python tests/long/python_rates.py). It prints
- bandpass of NumPy arrays beside scipy.signal.sosfiltfilt of the same order, each the best of the rounds, and how far
  the two differ where the ends do not show;
- what two threads of analyze_many gain over one, beside what two processes at once gain over one;
- the memory that reading a trial of 1e7 samples takes, in sizes of its array.
"""
import argparse
import pathlib
import subprocess
import sys
import tempfile
import time

import haptometer as hm
import numpy as np
import scipy.signal

RATE_HZ, ORDER = 10e3, 6


def best(rounds, *calls):
    """The least time of each call, which take turns."""
    times = [[] for _ in calls]
    for _ in range(rounds):
        for call, taken in zip(calls, times):
            begin = time.perf_counter()
            call()
            taken.append(time.perf_counter() - begin)
    return [min(taken) for taken in times]


def corners():
    """Of one pass, so that two passes together have -3 dB at 20 and 500 Hz."""
    low, high = np.tan(np.pi * np.array([20, 500]) / RATE_HZ)
    width = (high - low) / (np.sqrt(2) - 1) ** (1 / (2 * ORDER))
    half = np.sqrt(width**2 / 4 + low * high)
    return np.arctan([half - width / 2, half + width / 2]) * RATE_HZ / np.pi


def filters(samples, rounds):
    x = np.random.default_rng(1).normal(0, 1, samples)
    sos = scipy.signal.butter(ORDER, corners(), "bandpass", fs=RATE_HZ, output="sos")
    one, two, theirs = best(rounds, lambda: hm.bandpass(x, RATE_HZ, order=ORDER, threads=1),
                            lambda: hm.bandpass(x, RATE_HZ, order=ORDER), lambda: scipy.signal.sosfiltfilt(sos, x))
    apart = np.abs(hm.bandpass(x, RATE_HZ, order=ORDER) - scipy.signal.sosfiltfilt(sos, x))[20_000:-20_000].max()
    print(f"bandpass of {samples} samples: {one:.3f} s by one thread, {two:.3f} s by all, SciPy {theirs:.3f} s: "
          f"{theirs / one:.1f} and {theirs / two:.1f} times as fast; largest difference {apart:.2g} of noise of RMS 1")


def seconds_of(processes, paths):
    """The longest time that one of several processes takes for all trials, each on one thread."""
    script = (f"import time, haptometer as hm; paths = {paths!r}; hm.analyze_many(paths[:1]); begin = time.perf_counter()\n"
              f"hm.analyze_many(paths, threads=1); print(time.perf_counter() - begin)")
    running = [subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
               for _ in range(processes)]
    return max(float(process.communicate()[0]) for process in running)


def many(folder, trials, rounds):
    time_s = np.arange(30_000) / RATE_HZ
    paths = [str(folder / f"{k}.bin") for k in range(trials)]
    for k, path in enumerate(paths):
        noise = np.random.default_rng(k).normal(0, 1e-7, time_s.size)
        hm.Trial.from_arrays(1e-5 * np.sin(2 * np.pi * 225 * time_s) + noise, RATE_HZ).save(path)
    alone, together, one, two = [], [], [], []
    for _ in range(rounds):
        alone.append(seconds_of(1, paths))
        together.append(seconds_of(2, paths))
        taken = best(1, lambda: hm.analyze_many(paths, threads=1), lambda: hm.analyze_many(paths, threads=2))
        one.append(taken[0])
        two.append(taken[1])
    threads, processes = min(one) / min(two), 2 * min(alone) / min(together)
    print(f"analyze_many of {trials} trials of 3 s: {min(one):.3f} s by one thread, {min(two):.3f} s by two, a gain of "
          f"{threads:.2f}; two processes gain {processes:.2f}: {threads / processes:.2f} of it")


def reading(folder):
    rows = 10_000_000
    path = folder / "long.bin"
    hm.Trial.from_arrays(np.sin(np.arange(rows) * 0.14), RATE_HZ).save(path)
    script = f"""
import pathlib, re
import haptometer as hm
def kilobytes(name):
    return int(re.search(name + r":\\s+(\\d+)", pathlib.Path("/proc/self/status").read_text())[1])
before = kilobytes("VmRSS")
values = hm.read({str(path)!r})["displacement"].values
print(1024 * (kilobytes("VmHWM") - before) / values.nbytes)
"""
    made = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True)
    print(f"read of {rows} samples: {float(made.stdout):.2f} times the array's memory")


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--samples", type=int, default=25_000_000)
    words.add_argument("--trials", type=int, default=96)
    words.add_argument("--rounds", type=int, default=5)
    options = words.parse_args()
    filters(options.samples, options.rounds)
    with tempfile.TemporaryDirectory() as folder:
        many(pathlib.Path(folder), options.trials, options.rounds)
        reading(pathlib.Path(folder))


if __name__ == "__main__":
    main()
