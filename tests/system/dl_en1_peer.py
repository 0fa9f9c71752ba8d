"""A DL-EN1 of a few lines of Python, which `haptometer acquire` records over TCP.

Written from the maker's description alone (Keyence, DL-EN1 User's Manual, 633GB): CR LF lines over one
TCP connection, amplifiers from 01, values as a sign and nine digits without a point, FR for the decimal
places. It shares no code with the program, so a mistake that the emulator and `acquire` had in common
shows here.
"""

import json
import os
import re
import socket
import sys
import tempfile
import threading
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import programs
from programs import check

WANTED = 200
# the second amplifier's, poll by poll, where it is no measurement: the unit's own and an IL's
SPECIALS = {20: ("+099999999", "over"), 30: ("-099999999", "under"), 40: ("-099999998", "invalid"),
            50: ("+100000000", "device_error"), 60: ("+000099999", "over"),
            70: ("-000099999", "under"), 80: ("-000099998", "invalid")}
# IL-030 (three decimals of a millimetre) and IL-300 (two), 0.33 ms, 8 averages, sample hold
SETTINGS = {"01": {"195": 1, "132": 1, "133": 3, "136": 0}, "02": {"195": 4, "132": 1, "133": 3}}
DECIMALS = {"01": 3, "02": 2}


def number(value):
    return f"{value:+010d}"


def values(poll):
    second = SPECIALS[poll][0] if poll in SPECIALS else number(1000 - 3 * poll)
    return number(7 * poll - 500), second


class Unit(threading.Thread):
    def __init__(self):
        super().__init__(daemon=True)
        self.server = socket.create_server(("127.0.0.1", 0))
        self.server.settimeout(30)
        self.address = "127.0.0.1:%d" % self.server.getsockname()[1]
        self.polls = 0
        self.asked = []

    def answer(self, line):
        if line == "M0":
            self.polls += 1
            return "M0," + ",".join(values(self.polls))
        direct = re.fullmatch(r"(SR|FR),(\d\d),(\d\d\d)", line)
        if not direct:
            return f"ER,{line[:2]},255"
        command, unit, datum = direct.groups()
        if unit not in SETTINGS:
            return f"ER,{command},022"
        if command == "FR":
            return f"{line},{number(DECIMALS[unit])}" if datum == "037" else f"ER,{command},020"
        if datum not in SETTINGS[unit]:
            return f"ER,{command},016"
        return f"{line},{number(SETTINGS[unit][datum])}"

    def run(self):
        host, _ = self.server.accept()
        host.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        host.settimeout(30)
        waiting = b""
        while more := host.recv(4096):
            waiting += more
            while b"\r\n" in waiting:
                line, waiting = waiting.split(b"\r\n", 1)
                self.asked.append(line.decode())
                reply = self.answer(line.decode()).encode() + b"\r\n"
                # in two pieces, as a network may deliver them
                host.sendall(reply[:7])
                time.sleep(0.001)
                host.sendall(reply[7:])


def main():
    unit = Unit()
    unit.start()
    with tempfile.TemporaryDirectory() as directory:
        path = os.path.join(directory, "trial.bin")
        done = programs.run("acquire", "--sensor", "keyence-en1", "--port", unit.address, "--samples",
                            str(WANTED), "-o", path, "--json")
        summary = json.loads(done.stdout)
        check(summary["bad"] == len(SPECIALS), f"{summary['bad']} bad")
        check(not any(line.startswith("SW") for line in unit.asked), "something was written")
        rows = programs.rows(path)
        check(len(rows) == WANTED, f"{len(rows)} rows")
        # poll 1 was the probe; each further one is a row
        names = [name for name in rows[0] if name.startswith("displacement")]
        check(len(names) == 2, f"channels {names}")
        for poll, row in enumerate(rows, start=2):
            first_m, second_m = (row[name] for name in names)
            check(abs(float(first_m) - (7 * poll - 500) * 1e-6) < 1e-12, f"poll {poll}: {row}")
            if poll in SPECIALS:
                check(SPECIALS[poll][1] in row.values(), f"poll {poll}: {row}")
            else:
                check(abs(float(second_m) - (1000 - 3 * poll) * 1e-5) < 1e-12, f"poll {poll}: {row}")
        info = programs.run("trial", "info", path, "--json").stdout
        for text in ('"IL-030"', '"averages": 8', '"keyence_data_195_02": "+000000004"'):
            check(text in info, f"{text} is not in {info}")
    print(f"{WANTED} rows of two amplifiers, {len(SPECIALS)} special values: as handed out")


main()
