#!/usr/bin/env python3
"""A study whose trials are known from an earlier run: cached_study.py build/release/bin [--trials 10000]

Makes trials of one second (2 kHz, CSV; 100 subjects, 4 conditions), and times `study`: all of them for the first
time, all of them again, again with one new trial beside a plain reading of the cache, and with --verify, which has to
find a byte that changed while size, time and inode stayed. The bar: one new trial takes at most 2 s more than reading
the cache.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy

CONDITIONS = ("a", "b", "c", "d")
SUBJECTS = 100
BODIES = 40  # different vibrations, which the trials share; their labels differ
RATE_HZ = 2000
BAR_S = 2.0


def bodies():
    """Texts of a tone of 225 Hz with noise, each of its own amplitude."""
    draw = numpy.random.default_rng(1)
    times_s = numpy.arange(RATE_HZ) / RATE_HZ
    for k in range(BODIES):
        values_um = ((20 + 0.2 * k) * numpy.sin(2 * numpy.pi * 225 * times_s + draw.uniform(0, 6.28))
                     + 0.5 * draw.standard_normal(RATE_HZ))
        rows = "\n".join(f"{t:.4f},{x:.3f}" for t, x in zip(times_s, values_um, strict=True))
        yield f"time_s,displacement_um\n{rows}\n"


def write_trials(folder, first, count, texts):
    for k in range(first, first + count):
        subject, rest = k % SUBJECTS + 1, k // SUBJECTS
        condition, repeat = CONDITIONS[rest % 4], rest // 4 + 1
        head = f"# label.subject = {subject}\n# label.condition = {condition}\n# label.repeat = {repeat}\n"
        body = texts[(subject * subject + 7 * (rest % 4) + repeat) % BODIES]
        (folder / f"t{k:06d}.csv").write_text(head + body)


def timed(program, folder, cache, *words, status=0):
    """Seconds of a `study`, its document without the provenance, and what it said on stderr."""
    begun = time.monotonic()
    done = subprocess.run([program, "study", folder, "--json", *words], capture_output=True, text=True, check=False,
                          env={**os.environ, "HAPTOMETER_CACHE": str(cache)})
    seconds = time.monotonic() - begun
    if done.returncode != status:
        sys.exit(f"FAILED: status {done.returncode}: {done.stderr[:500]}")
    document = json.loads(done.stdout)
    document.pop("provenance")
    return seconds, document, done.stderr


def read_cache(cache):
    begun = time.monotonic()
    size = sum(len(path.read_bytes()) for path in cache.iterdir())
    return time.monotonic() - begun, size


def change_behind(path):
    state = path.stat()
    text = bytearray(path.read_bytes())
    text[-4] = ord("1") if text[-4] != ord("1") else ord("2")
    with path.open("r+b") as file:
        file.write(text)
    os.utime(path, ns=(state.st_atime_ns, state.st_mtime_ns))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("programs")
    parser.add_argument("--trials", type=int, default=10_000)
    given = parser.parse_args()
    program = os.path.abspath(os.path.join(given.programs, "haptometer"))
    with tempfile.TemporaryDirectory() as name:
        folder, cache = pathlib.Path(name) / "trials", pathlib.Path(name) / "cache"
        folder.mkdir()
        texts = list(bodies())
        write_trials(folder, 0, given.trials, texts)
        print(f"first run:        {timed(program, folder, cache)[0]:7.2f} s")
        print(f"all known:        {timed(program, folder, cache)[0]:7.2f} s")
        reading_s, size = read_cache(cache)
        print(f"reading the cache:{reading_s:7.2f} s, {size / 1e6:.1f} MB")
        write_trials(folder, given.trials, 1, texts)
        seconds, known, said = timed(program, folder, cache)
        print(f"one new trial:    {seconds:7.2f} s, {said.strip()}")
        fresh = timed(program, folder, cache, "--no-cache")[1]
        print(f"the same as without a cache: {known == fresh}")
        changed = folder / "t000007.csv"
        change_behind(changed)
        verify_s, _, said = timed(program, folder, cache, "--verify", status=1)
        print(f"--verify:         {verify_s:7.2f} s, finds the changed byte: {changed.name in said}")
        holds = seconds <= reading_s + BAR_S and known == fresh and changed.name in said
        sys.exit(0 if holds else 1)


if __name__ == "__main__":
    main()
