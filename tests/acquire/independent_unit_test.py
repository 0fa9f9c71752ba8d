"""acquire against a DL-RS1A and a streaming head of a few lines of Python.

The emulator shares its protocol code with acquire, so a common mistake would hide between them. This
peer knows only the bytes of the maker's manual: `M0` CR LF is answered by `M0,+00.018` CR LF.
"""
import json
import os
import pty
import select
import signal
import sys
import tempfile
import threading
import time
import tty

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import check, rows, run

VALUES = [b"-00.007", b"+00.018", b"+12.345", b"-14.999", b"+00.000"]
SPECIAL = {7: (b"+99.999", "over"), 11: (b"-99.999", "under"), 13: (b"-99.998", "invalid"),
           17: (b"+EE.EEE", "device_error")}


class Peer:
    """The device's end of a pseudo-terminal, served by a thread until close()."""

    def __init__(self, serve):
        self.master, slave = pty.openpty()
        tty.setraw(slave)
        self.slave = slave  # kept open, so that the master never reads a hang-up
        self.path = os.ttyname(slave)
        self.running = True
        self.thread = threading.Thread(target=serve, args=(self,))
        self.thread.start()

    def readable(self, seconds):
        return select.select([self.master], [], [], seconds)[0]

    def close(self):
        self.running = False
        self.thread.join()
        os.close(self.slave)
        os.close(self.master)


def unit(peer):
    heard, polls = b"", 0
    while peer.running:
        if not peer.readable(0.05):
            continue
        heard += os.read(peer.master, 64)
        while b"\r\n" in heard:
            command, heard = heard.split(b"\r\n", 1)
            time.sleep(0.004)
            if command == b"M0":
                value = SPECIAL[polls][0] if polls in SPECIAL else VALUES[polls % len(VALUES)]
                os.write(peer.master, b"M0," + value + b"\r\n")
                polls += 1
            elif command == b"SR,00,195":
                os.write(peer.master, b"SR,00,195,1\r\n")
            else:
                os.write(peer.master, b"ER," + command[:2] + b",22\r\n")


def head(peer):
    start, sent = time.monotonic(), 0
    while peer.running:
        due = int((time.monotonic() - start) * 2000)
        lines = b"".join(b"%+08.4f\r" % ((k % 1000 - 500) / 1e4) for k in range(sent, due))
        if lines and select.select([], [peer.master], [], 0)[1]:
            os.write(peer.master, lines)
        sent = due
        time.sleep(0.002)


def acquire(peer, trial, *options):
    done = run("acquire", "--port", peer.path, "-o", trial, "--json", *options)
    return json.loads(done.stdout), done.stderr


def test_unit(directory):
    peer = Peer(unit)
    summary, said = acquire(peer, f"{directory}/unit.bin", "--baud", "38400", "--samples", "40")
    peer.close()
    check(summary["readings"] == 40, f"40 readings: {summary}")
    check("virtual terminal" in summary["source"], summary["source"])
    check("20-500 Hz cannot be observed" in said, said)
    # poll 0 was the probe; each further one is a row
    for number, row in enumerate(rows(f"{directory}/unit.bin"), start=1):
        if number in SPECIAL:
            check(row["status"] == SPECIAL[number][1], f"poll {number}: {row}")
            continue
        check(row["status"] in ("ok", "repeated"), f"poll {number}: {row}")
        expected_m = float(VALUES[number % len(VALUES)]) * 1e-3
        check(abs(float(row["displacement_m"]) - expected_m) < 1e-12, f"poll {number}: {row}")
    check(summary["bad"] == len(SPECIAL), f"bad: {summary}")


def test_head(directory):
    peer = Peer(head)
    summary, _ = acquire(peer, f"{directory}/head.bin", "--sensor", "stream", "--samples", "1500")
    peer.close()
    check(summary["readings"] == 1500 and summary["bad"] == 0, f"1500 readings: {summary}")
    counts = [round(float(row["displacement_m"]) * 1e7) for row in rows(f"{directory}/head.bin")]
    for before, after in zip(counts, counts[1:]):
        check(after - before in (1, -999), f"a line was lost between {before} and {after}")


signal.alarm(120)
with tempfile.TemporaryDirectory() as temporary:
    test_unit(temporary)
    test_head(temporary)
