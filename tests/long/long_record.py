#!/usr/bin/env python3
"""How long `analyze` takes over a trial far longer than a few blocks, against a plain read of the same file.

  /usr/bin/python3 tests/long/long_record.py build/release/bin [ROWS [DIRECTORY]]

Writes trials of ROWS readings (1e8) at 10 kHz and at 392 kHz, i32 counts of 10 nm, a tone of 1 um in 0.5 mm of tremor:
by docs/reference/formats.md, without the program's own writer. Then, in turns, five times each: a read of the file with zlib's
crc32 of every 64 KiB, one with SHA-256, and the whole process `analyze --json --threads N` for N = 1 and 2. Prints the
medians, the peak of resident memory, the RMS against the truth, and whether both give the same bytes. The bars: with
two threads four times the plain read, apart from the hash of the input that the answer states, and below 200 MB. Ends
with 1 if one is missed.
"""
import hashlib
import json
import math
import os
import re
import statistics
import struct
import subprocess
import sys
import tempfile
import time
import zlib

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import program

SIGNATURE = bytes([0x93]) + b"haptrial\r\n\x1a\n" + bytes([1, 0xFE, 0])
MAGIC = bytes([0x93]) + b"block\r\n"
STEP_M = 1e-8
BLOCK_ROWS = 13107
TURNS = 5
MOST_BYTES = 200e6
MOST_READS = 4


def block(kind, sequence, rows, first_row, payload):
    head = MAGIC + struct.pack("<IIIIQqI", kind, sequence, rows, len(payload), first_row, first_row,
                               zlib.crc32(payload))
    return head + struct.pack("<I", zlib.crc32(head)) + payload


def header(rate_hz):
    channel = {"name": "displacement", "role": "displacement", "unit": "m", "encoding": "i32", "scale": STEP_M,
               "offset": 0.03, "range_min": None, "range_max": None, "resolution": STEP_M}
    text = {key: "" for key in ("sensor", "head", "hold", "laser_spot", "utc_start", "host", "command_line")}
    numbers = {key: None for key in ("sampling_s", "averages", "drive_frequency_hz", "drive_amplitude_v")}
    return {"format": "haptometer trial", "timing": "uniform", "rate_hz": rate_hz, "channels": [channel],
            "source": "simulated", **text, **numbers, "nominal_rate_hz": rate_hz, "tare_m": 0, "labels": {},
            "fields": {}, "notes": []}


def write_trial(path, rows, rate_hz):
    """Tone and tremor, each a whole number of periods in ten seconds, which are repeated."""
    period = int(10 * rate_hz)
    t_s = np.arange(period) / rate_hz
    motion_m = 1e-6 * np.sin(2 * math.pi * 100 * t_s + 1) + 5e-4 * np.sin(2 * math.pi * 8.3 * t_s)
    packed = np.zeros(period, dtype=[("counts", "<i4"), ("status", "u1")])
    packed["counts"] = np.round(motion_m / STEP_M)
    ring = packed.tobytes() * 2
    text = json.dumps(header(rate_hz)).encode()
    with open(path, "wb") as file:
        file.write(SIGNATURE + block(1, 0, 0, 0, text) + block(1, 1, 0, 0, text))
        sequence, row = 2, 0
        while row < rows:
            count = min(BLOCK_ROWS, rows - row)
            begin = row % period * 5
            file.write(block(2, sequence, count, row, ring[begin:begin + 5 * count]))
            sequence, row = sequence + 1, row + count
        close = json.dumps({"rows": rows, "statuses": {"ok": rows}}).encode()
        file.write(block(4, sequence, 0, rows, close))


def read_s(path, take):
    """Seconds of a read of the file, every 64 KiB of it given to `take`."""
    began = time.monotonic()
    buffer = memoryview(bytearray(1 << 16))
    with open(path, "rb", buffering=0) as file:
        while count := file.readinto(buffer):
            take(buffer[:count])
    return time.monotonic() - began


def analyze(path, threads):
    """Seconds, peak bytes and the answer printed, without its provenance, which states the time and the command."""
    began = time.monotonic()
    process = subprocess.Popen([program("haptometer"), "analyze", "--json", "--threads", str(threads), path],
                               stdout=subprocess.PIPE)
    out = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    assert status == 0, out
    return time.monotonic() - began, usage.ru_maxrss * 1024, out[:out.index(b'"provenance"')]


def measure(path, rate_hz):
    """Whether the bars are met."""
    reads, hashes, runs, peaks, outs = [], [], {1: [], 2: []}, [], set()
    for _ in range(TURNS):
        reads.append(read_s(path, zlib.crc32))
        hashes.append(read_s(path, hashlib.sha256().update))
        for threads, times in runs.items():
            seconds, peak, out = analyze(path, threads)
            times.append(seconds)
            peaks.append(peak)
            outs.add(out)
    plain_s, hash_s, both_s = (statistics.median(times) for times in (reads, hashes, runs[2]))
    cost = (both_s - hash_s) / plain_s
    rms_m = float(re.search(rb'"band_rms_m": (\S+),', out)[1])
    truth_m = 1e-6 / math.sqrt(2)
    print(f"{rate_hz:g} Hz: plain read {plain_s:.3f} s ({min(reads):.3f}-{max(reads):.3f}), hash {hash_s:.3f} s, "
          f"one thread {statistics.median(runs[1]):.3f} s, two {both_s:.3f} s ({min(runs[2]):.3f}-{max(runs[2]):.3f}): "
          f"without the hash {cost:.2f} reads, {max(peaks) / 1e6:.0f} MB, RMS {rms_m / truth_m - 1:+.1e} "
          f"of the truth, {'same bytes' if len(outs) == 1 else 'DIFFERENT BYTES'}")
    return cost <= MOST_READS and max(peaks) < MOST_BYTES and len(outs) == 1


def main():
    os.environ["HAPTOMETER_PROGRAMS"] = sys.argv[1]
    rows = int(float(sys.argv[2])) if len(sys.argv) > 2 else 100_000_000
    held = True
    with tempfile.TemporaryDirectory(dir=sys.argv[3] if len(sys.argv) > 3 else None) as directory:
        for rate_hz in (10e3, 392e3):
            path = os.path.join(directory, "trial.bin")
            write_trial(path, rows, rate_hz)
            held &= measure(path, rate_hz)
    sys.exit(not held)


if __name__ == "__main__":
    main()
