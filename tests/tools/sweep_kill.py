#!/usr/bin/env python3
"""Kills a running `haptometer sweep` at random moments (kill -9, by its pid) and goes on with --resume: is the table
in the end, byte for byte but for its provenance, that of a run that nobody disturbed?

  /usr/bin/python3 tests/tools/sweep_kill.py [SWEEPS]

Scenes with a run of 0.1 s, so that a row takes a while. Each sweep is killed until it comes to its end by itself,
a third of them also by Ctrl-C, after which it must say so (status 130) and leave whole rows. The moments follow a
seed that is printed.
"""
import os
import random
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import DEADLINE_S, SCENE, check, program, run

QUESTION = ["sweep", SCENE, "--vary", "run.duration_s=0.1,0.11", "--vary", "drive.frequency_hz=150:300:201",
            "--vary", "skin.stiffness_n_per_m=600,1200"]
LEAST_KILLS = 3   # of a sweep, while rows are still to be made


def content(path):
    """Without the provenance, which differs from command to command."""
    with open(path, "rb") as file:
        return b"".join(line for line in file if not line.startswith(b"# provenance: "))


def start(table, threads):
    return subprocess.Popen([program("haptometer"), *QUESTION, "-o", table, "--resume", "--threads", str(threads)],
                            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def disturb(table, whole, moments):
    """Starts and kills until a run comes to its end; how often it was killed."""
    kills, took_s = 0, 0.05
    while True:
        process = start(table, moments.choice((1, 2, 3)))
        by = signal.SIGINT if moments.random() < 1 / 3 else signal.SIGKILL
        time.sleep(took_s * moments.random() if kills else took_s)
        process.send_signal(by)
        said = process.communicate(timeout=DEADLINE_S)[1].decode()
        there = content(table) if os.path.exists(table) else b""
        check(whole.startswith(there), f"after {kills + 1} kills the table is no beginning of the whole one")
        if process.returncode == 0:
            return kills, len(there)
        # a signal that comes before it is caught ends the program as any other
        check(process.returncode in (130, -signal.SIGINT, -signal.SIGKILL),
              f"ends with {process.returncode}: {said}")
        if process.returncode == 130:
            check("continue with --resume" in said, said)
            check(there.endswith(b"\n"), "Ctrl-C leaves a part of a row")
        kills += 1
        took_s = min(1.5 * took_s, 2.0)  # on a busy machine it needs longer to come anywhere


def main():
    sweeps = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    seed = random.SystemRandom().randrange(10**6)
    print(f"seed {seed}")
    moments = random.Random(seed)
    with tempfile.TemporaryDirectory() as directory:
        plain = os.path.join(directory, "plain.csv")
        run(*QUESTION, "-o", plain)
        whole = content(plain)
        killed = 0
        for number in range(sweeps):
            table = os.path.join(directory, f"{number}.csv")
            kills, size = disturb(table, whole, moments)
            check(content(table) == whole, "the table differs from the undisturbed one")
            killed += kills
            print(f"sweep {number}: {kills} kills, {size} bytes the same")
        check(killed >= LEAST_KILLS, f"only {killed} kills hit a running sweep")


if __name__ == "__main__":
    main()
