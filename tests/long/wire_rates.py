#!/usr/bin/env python3
"""How close does `acquire` come to a bare write-read loop on the same emulated DL-RS1A, at each baud?

  /usr/bin/python3 tests/long/wire_rates.py build/release/bin [SECONDS]

The bare loop writes `M0 CR LF`, waits in poll(2) and reads to the line feed, in this process; then `acquire`
records from the same emulator, and the loop runs once more, so that both saw the same machine. The bars: at
least 99 % of the loop, and under 2 % of a core. Ends with 1 if one is missed.
"""
import json
import os
import select
import subprocess
import sys
import tempfile
import time
import tty

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import Emulator, program


def bare_loop(path, seconds):
    port = os.open(path, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(port)
    poll = select.poll()
    poll.register(port, select.POLLIN)
    exchanges, began = 0, time.monotonic()
    while time.monotonic() - began < seconds:
        os.write(port, b"M0\r\n")
        reply = b""
        while not reply.endswith(b"\n"):
            assert poll.poll(2000), "no answer within 2 s"
            reply += os.read(port, 256)
        exchanges += 1
    elapsed = time.monotonic() - began
    os.close(port)
    return exchanges / elapsed


def acquire(link, baud, seconds, trial):
    began = time.monotonic()
    process = subprocess.Popen(
        [program("acquire"), "--port", link, "--baud", str(baud), "--duration",
         f"{seconds}s", "-o", trial, "--json"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    summary = json.loads(process.stdout.read())
    _, status, usage = os.wait4(process.pid, 0)
    assert status == 0, status
    cpu = 100 * (usage.ru_utime + usage.ru_stime) / (time.monotonic() - began)
    return summary["rate_hz"], cpu, summary


def main():
    os.environ["HAPTOMETER_PROGRAMS"] = sys.argv[1]
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 15
    missed = False
    for baud in (9600, 19200, 38400):
        with tempfile.TemporaryDirectory() as directory:
            link = os.path.join(directory, "sensor")
            with Emulator("--baud", str(baud), "--link", link):
                before = bare_loop(link, seconds / 2)
                rate, cpu, summary = acquire(link, baud, seconds, os.path.join(directory, "trial.bin"))
                after = bare_loop(link, seconds / 2)
        bare = (before + after) / 2
        holds = rate >= 0.99 * bare and cpu < 2
        missed |= not holds
        print(f"{baud} baud: acquire {rate:.2f}/s, bare loop {before:.2f} and {after:.2f}/s: "
              f"{100 * rate / bare:.2f} %, processor {cpu:.2f} %, {summary['bad']} bad, "
              f"{summary['repeated']} repeated: {'holds' if holds else 'MISSED'}")
    sys.exit(missed)


if __name__ == "__main__":
    main()
