"""An independent peer of both sides of the DL-RS1A's wire.

Written from the maker's description alone (Keyence, DL-RS1A User's Manual, IL Edition, p. 6-15): CR
LF lines, one command at a time, values as sign, two digits, point, three digits. It shares no code
with the program, so a mistake that the emulator and `acquire` had in common shows here.

  dl_rs1a_peer.py client    polls `haptometer emulate` and checks its bytes and its pace
  dl_rs1a_peer.py device    is a unit on a pseudo-terminal that `haptometer acquire` records
"""

import json
import os
import pty
import re
import select
import subprocess
import sys
import tempfile
import time
import tty

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import programs
from programs import check

DEADLINE_S = 30

# what has no number: over, under, no measurement, device error
SPECIALS = {"+99.999": "over", "-99.999": "under", "-99.998": "invalid", "+EE.EEE": "device_error"}


# --- the host's side ---------------------------------------------------------------------------


class Host(programs.Emulator):
    """The host of a running `haptometer emulate`."""

    def __init__(self, *options):
        super().__init__("--duration", "120s", *options)
        check(self.port.startswith("/dev/"), f"port {self.port}")
        self.wire = os.open(self.port, os.O_RDWR | os.O_NOCTTY)

    def __exit__(self, *_):
        os.close(self.wire)
        self.end()

    def ask(self, request):
        """The answer to `request`, and how long it took from before the write to after the read."""
        begin = time.monotonic()
        os.write(self.wire, request)
        answer = b""
        while not answer.endswith(b"\n"):
            ready, _, _ = select.select([self.wire], [], [], 2)
            check(ready, f"no answer to {request!r}, only {answer!r}")
            answer += os.read(self.wire, 1)
        return answer, time.monotonic() - begin


def allowed_period_s(baud):
    """M0 CR LF out, 4 ms of processing, M0,+dd.ddd CR LF back, 10 bits a character."""
    return (4 + 12) * 10 / baud + 4e-3


def poll(emulator, seconds):
    """Polls as fast as it goes. Returns the values and the rate; every byte is checked."""
    values = []
    shortest = 1e9
    begin = time.monotonic()
    while time.monotonic() - begin < seconds:
        answer, took = emulator.ask(b"M0\r\n")
        check(re.fullmatch(rb"M0,[+-]\d\d\.\d{3}\r\n", answer), f"M0 answers {answer!r}")
        values.append(answer[3:10])
        shortest = min(shortest, took)
    elapsed = time.monotonic() - begin
    ready, _, _ = select.select([emulator.wire], [], [], 0.05)
    check(not ready, "bytes that nobody asked for")
    return values, len(values) / elapsed, shortest


def client():
    # what every request of the manual is answered with
    with Host("--baud", "38400") as emulator:
        for request, answer in [
            (b"MS\r\n", rb"MS,0\d,[+-]\d\d\.\d{3}\r\n"),
            (b"M0\r", rb"M0,[+-]\d\d\.\d{3}\r\n"),
            (b"SR,00,037\r\n", rb"SR,00,037,[+-]\d\d\.\d{3}\r\n"),
            (b"SR,00,195\r\n", rb"SR,00,195,1\r\n"),
            (b"SR,00,132\r\n", rb"SR,00,132,2\r\n"),
            (b"SR,00,133\r\n", rb"SR,00,133,4\r\n"),
            (b"SR,00,200\r\n", rb"SR,00,200,\w*EMULATED\w*\r\n"),
            (b"SR,06,101\r\n", rb"ER,SR,65\r\n"),
            (b"SR,00,999\r\n", rb"ER,SR,22\r\n"),
            (b"SR,00\r\n", rb"ER,SR,21\r\n"),
            (b"SW,00,001,1\r\n", rb"ER,SW,67\r\n"),
            (b"AW,001,1\r\n", rb"ER,AW,67\r\n"),
            (b"ZZ\r\n", rb"ER,ZZ,00\r\n"),
        ]:
            got, _ = emulator.ask(request)
            check(re.fullmatch(answer, got), f"{request!r} is answered with {got!r}")

    # the pace: never above the wire's; how much slower a busy machine makes it is printed, not judged
    for baud in (9600, 38400):
        with Host("--baud", str(baud)) as emulator:
            period = allowed_period_s(baud)
            _, rate, shortest = poll(emulator, 2)
            print(f"{baud} baud: {rate:.2f} polls/s of {1 / period:.2f}, {100 * rate * period:.1f} %; "
                  f"shortest exchange {1e3 * shortest:.3f} ms of {1e3 * period:.3f} ms")
            check(shortest >= period - 1e-6, f"{shortest} s for an exchange")
            check(rate * period <= 1 + 1e-6, f"{rate} polls/s")

    # the buffer: polls within a refresh get the same reading
    with Host("--baud", "38400", "--refresh", "100ms") as emulator:
        begin = time.monotonic()
        values, _, _ = poll(emulator, 1)
        changes = sum(a != b for a, b in zip(values, values[1:]))
        check(1 <= changes <= 1 + (time.monotonic() - begin) / 0.1, f"{changes} contents in 1 s")
        print(f"refreshed every 100 ms: {len(values)} polls, {changes + 1} contents")


# --- the device's side -------------------------------------------------------------------------


def plan():
    """The values to answer with: mostly new ones, some twice, some that are no measurement."""
    values = []
    for i in range(400):
        value = f"{'+-'[i % 2]}{i % 10:02d}.{(37 * i) % 1000:03d}"
        values.append(value)
        if i % 5 == 0:
            values.append(value)
        if i % 40 == 7:
            values.append(list(SPECIALS)[i // 40 % 4])
    return values


# one amplifier, IL-030, 1 ms, 16 averages, sample hold; what the unit does not know it refuses
SETTINGS = {b"033": b"00000", b"098": b"0", b"132": b"2", b"133": b"4", b"136": b"0", b"152": b"0",
            b"159": b"0", b"195": b"1", b"200": b"IL-1000"}


def serve(master, values, process):
    """Answers until `process` ends. Returns the values that were handed out, with their times."""
    handed_out = []
    waiting = b""
    deadline = time.monotonic() + DEADLINE_S
    while process.poll() is None:
        check(time.monotonic() < deadline, "acquire does not end")
        if not select.select([master], [], [], 0.05)[0]:
            continue
        try:
            waiting += os.read(master, 4096)
        except OSError:  # the host has closed the port
            continue
        while b"\r" in waiting:
            line, waiting = waiting.split(b"\r", 1)
            waiting = waiting.lstrip(b"\n")
            line = line.strip(b"\n")
            if line == b"M0":
                value = values[len(handed_out) % len(values)]
                handed_out.append((value, time.monotonic()))
                answer = b"M0," + value.encode()
            elif line.startswith(b"SR,00,") and line[6:] in SETTINGS:
                answer = line + b"," + SETTINGS[line[6:]]
            else:
                answer = b"ER," + line[:2] + b",22"
            # in two pieces, as a serial line delivers them
            os.write(master, answer[:4])
            os.write(master, answer[4:] + b"\r\n")
    return handed_out


def exported(path):
    """(displacement in m or None, status) of every row of a trial."""
    return [(float(row["displacement_m"]) if row["displacement_m"] not in ("", "nan") else None,
             row["status"]) for row in programs.rows(path)]


def find(rows, expected):
    """Where the rows begin within what was handed out: acquire asks before it records."""
    numbers = [None if value in SPECIALS else round(float(value) * 1000) for value in expected]
    counts = [None if metres is None else round(metres * 1e6) for metres, _ in rows]
    for start in range(len(numbers) - len(counts) + 1):
        if numbers[start:start + len(counts)] == counts:
            return start
    sys.exit("FAILED: the recorded rows are not what the device handed out, in order")


def device():
    master, slave = pty.openpty()
    tty.setraw(slave)
    wanted = 600
    with tempfile.TemporaryDirectory() as directory:
        path = os.path.join(directory, "trial.bin")
        process = subprocess.Popen(
            [programs.program("acquire"), "--port", os.ttyname(slave), "--baud", "38400", "--samples",
             str(wanted), "-o", path, "--json"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        handed_out = serve(master, plan(), process)
        summary = json.loads(process.stdout.read())
        check(process.returncode == 0, f"acquire ends with {process.returncode}")
        check(summary["readings"] == wanted, f"{summary['readings']} readings")

        # every value handed out is there once, in order, to the last digit
        rows = exported(path)
        check(len(rows) == wanted, f"{len(rows)} rows")
        start = find(rows, [value for value, _ in handed_out])
        recorded = handed_out[start:start + wanted]
        bad = 0
        for (value, _), (_, status) in zip(recorded, rows):
            if value in SPECIALS:
                bad += 1
                check(status == SPECIALS[value], f"{value} is marked {status}")
            else:
                check(status in ("ok", "repeated"), f"{value} is marked {status}")
        check(summary["bad"] == bad, f"{summary['bad']} bad, {bad} handed out")

        # a repetition can be told within the unit's refresh of 7 ms, so only what came well within
        # it must be marked, and a new value never may
        unmarked = 0
        for i in range(1, wanted):
            same = recorded[i][0] == recorded[i - 1][0]
            soon = recorded[i][1] - recorded[i - 1][1] < 3e-3
            marked = rows[i][1] == "repeated"
            check(same or not marked, f"{recorded[i][0]} is new and marked repeated")
            unmarked += same and soon and not marked
        # a machine that is busy elsewhere may bring a reply to acquire more than 7 ms after the one before
        check(unmarked <= wanted // 100, f"{unmarked} of {wanted} are the same and not marked")
        repeated = sum(status == "repeated" for _, status in rows)
        check(summary["repeated"] == repeated > 0, f"{repeated} repeated")
        check(summary["distinct"] == wanted - bad - repeated, f"{summary['distinct']} distinct")
        print(f"{wanted} readings, {bad} bad, {repeated} repeated: as handed out")


if __name__ == "__main__":
    {"client": client, "device": device}[sys.argv[1]]()
