#!/usr/bin/env python3
"""Whether `analyze --json` prints the same bytes with one thread and with two, through the whole process.

  /usr/bin/python3 tests/tools/analyze_threads.py

A trial of 2.5 million readings, more than is read at a time, with a damaged block that splits it. Invariant: no number
depends on how many threads found it.
"""
import json
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "long"))
from long_record import write_trial
from programs import check, run

ROWS = 2_500_000


def damage(path, share):
    """Turns one bit over."""
    with open(path, "r+b") as file:
        at = int(os.path.getsize(path) * share)
        file.seek(at)
        byte = file.read(1)[0]
        file.seek(at)
        file.write(bytes([byte ^ 1]))


def printed(path, threads):
    """The answer without its provenance, which names the command and the time."""
    answer = json.loads(run("analyze", "--json", "--threads", str(threads), path).stdout)
    del answer["provenance"]
    return json.dumps(answer)


def main():
    with tempfile.TemporaryDirectory() as directory:
        path = os.path.join(directory, "trial.bin")
        write_trial(path, ROWS, 10e3)
        damage(path, 0.1)
        check(printed(path, 1) == printed(path, 2), "two threads print other bytes than one")
    print("same bytes")


if __name__ == "__main__":
    main()
