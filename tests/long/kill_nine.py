#!/usr/bin/env python3
"""Kills a recording at random moments (kill -9) and reads back what is there: is every whole block read, and is
every value one that the sensor has sent?

  /usr/bin/python3 tests/long/kill_nine.py PROGRAMS [MOMENTS [LATEST_S]]

PROGRAMS holds the program, MOMENTS is 200, LATEST_S (5, so that most are killed behind their first flush, which
takes a second) the latest moment after the recording's start. Each time
`haptometer emulate` plays a scene with noise, 1000 lines a second; its noise depends only on the seed, so the
same emulator read here byte by byte gives the sequence that every recording must be a piece of. Trials are read
by the Python reader of docs/reference/formats.md, not by the program. Ends with 1 if a bar is missed, with 77 without
NumPy.
"""
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import programs

try:
    import numpy as np
except ImportError:
    programs.skip("needs python3-numpy")

RATE_HZ = 1000
DEADLINE_S = 30


def emulator():
    return programs.Emulator("--protocol", "stream", "--baud", "115200", "--sampling", "1ms", "--seed",
                             "9", "--duration", "120s")


def sent(seconds):
    """The counts (0.1 um) that the emulator sends, from its first line on."""
    data, lines = b"", int(RATE_HZ * seconds)
    with emulator() as device:
        port = os.open(device.port, os.O_RDWR | os.O_NOCTTY)
        while data.count(b"\r") < lines:
            data += os.read(port, 4096)
        os.close(port)
    whole = re.findall(rb"[+-]\d\d\.\d{4}(?=\r)", data)
    return np.array([int(line.replace(b".", b"")) for line in whole])


def corrupt_values(values, sequence):
    """How many of `values` are not the emulator's, in its order. A loaded machine may lose lines on the wire
    (after which the sequence is found again further on, by the next six values, or by two where more lines are
    lost soon after); a value that was never sent is corrupt."""
    corrupt, at, i = 0, 0, 0
    while i < len(values):
        if at < len(sequence) and values[i] == sequence[at]:
            at, i = at + 1, i + 1
            continue
        found = [place for probe in (6, 2) if (place := place_of(values[i:i + probe], sequence[at:])) is not None]
        if found:
            at += found[0]
        else:
            corrupt, i = corrupt + 1, i + 1
    return corrupt


def place_of(values, sequence):
    """Where `values` stand in `sequence` first, one after the other."""
    if len(sequence) < len(values):
        return None
    windows = np.lib.stride_tricks.sliding_window_view(sequence, len(values))
    found = np.flatnonzero((windows == values).all(axis=1))
    return int(found[0]) if len(found) else None


def kill_once(directory, number, moment_s):
    """The bytes of the trial just before the kill, and the trial."""
    path = os.path.join(directory, f"{number}.bin")
    with emulator() as device:
        acquire = subprocess.Popen(
            [programs.program("acquire"), "--sensor", "stream", "--baud", "115200", "--port", device.port,
             "--duration", "60s", "-o", path],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + DEADLINE_S
        while not os.path.exists(path) and time.monotonic() < deadline:
            time.sleep(0.001)
        time.sleep(moment_s)
        before = open(path, "rb").read()
        acquire.send_signal(signal.SIGKILL)
        ended = acquire.wait(DEADLINE_S)
        assert ended == -signal.SIGKILL, f"acquire had ended before, with {ended}"
    return before, path


def main():
    if len(sys.argv) > 1:
        os.environ["HAPTOMETER_PROGRAMS"] = sys.argv[1]
    moments = int(sys.argv[2]) if len(sys.argv) > 2 else 200
    latest_s = float(sys.argv[3]) if len(sys.argv) > 3 else 5.0
    read_trial = programs.trial_reader()
    missing = corrupt = changed = rows_read = partial = no_rows = unread = 0
    random.seed(1)
    with tempfile.TemporaryDirectory() as directory:
        snapshot = os.path.join(directory, "before.bin")
        pool = ThreadPoolExecutor(5)  # they mostly sleep
        # the emulator runs a little longer than the recording, and more where the machine is loaded
        reading = pool.submit(sent, latest_s + 2)
        moments_s = [random.uniform(0, latest_s) for _ in range(moments)]
        runs = pool.map(lambda run: kill_once(directory, *run), enumerate(moments_s))
        sequence = reading.result()
        for before, path in runs:
            after = open(path, "rb").read()
            changed += not after.startswith(before)
            if len(after) < 16 + 48:
                unread += 1  # killed within its first bytes: nothing had been promised
                continue
            header, rows, _, _, rest = read_trial(path)
            if header is None:
                unread += 1
                continue
            values = np.concatenate([b["value0"] for _, b in rows]) if rows else np.array([], int)
            statuses = np.concatenate([b["status0"] for _, b in rows]) if rows else np.array([], int)
            # what was in the file before the kill is read after it
            open(snapshot, "wb").write(before)
            if len(before) >= 16 + 48:
                before_rows = sum(len(b) for _, b in read_trial(snapshot)[1])
                missing += before_rows > len(values)
            indices = [first for first, _ in rows]
            lengths = [len(b) for _, b in rows]
            missing += indices != [sum(lengths[:i]) for i in range(len(lengths))]
            good = statuses <= 1
            corrupt += corrupt_values(values[good], sequence)
            rows_read += len(values)
            no_rows += not len(values)
            partial += rest > 0
            os.unlink(path)
    print(f"{moments} moments: {rows_read} rows read, {no_rows} trials killed before their first block, "
          f"{partial} within a block, {unread} within the header")
    bars = {"whole blocks missing": missing, "bytes changed behind the recorder": changed,
            "corrupt values": corrupt, "trials without any row to judge": rows_read == 0}
    for name, value in bars.items():
        print(f"{'ok  ' if not value else 'FAIL'} {name}: {int(value)}")
    sys.exit(any(bars.values()))


if __name__ == "__main__":
    main()
