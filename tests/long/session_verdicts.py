"""Verdicts of a session on what goes wrong in a laboratory, and on good trials, all from one generator.

  tests/long/session_verdicts.py PROGRAMS [--each 20] [--good 1000] [--jobs 2]

Each kind of fault is a session of its own, with `--each` trials; each of them must be CHECK or BAD with the reason of
that fault. Of `--good` trials in sessions of 96 at most 2 % may be other than GOOD. Samples come through
`--sensor pipe`, 3 s at 10 kHz: a tone of 20 to 150 um at 225 Hz that begins after 0.4 s, its amplitude wandering by
0.5 %, tremor of 3 to 20 um, drift, and 0.5 um of noise in steps of 0.1 um. Averaging is that of a scene's sensor.
Exits with 77 where NumPy is missing.
"""
import argparse
import concurrent.futures
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import DEADLINE_S, SCENE, check, program, run, skip, wait_for

try:
    import numpy as np
except ImportError:
    skip("needs python3-numpy")

RATE_HZ, SECONDS = 10_000, 3
LIMITS = "tone=225Hz+-1Hz, change<5%, bad<1%, steady>2s, distance=30mm+-2mm, tremor<50um, repeats<25%"
PIPE = ["--sensor", "pipe", "--format", "f64", "--rate", f"{RATE_HZ}Hz", "--channels", "displacement:m"]


def trial(rng, amplitude_m=None, frequency_hz=225.0, distance_m=None, envelope=None):
    """The distance in m, sample by sample."""
    t = np.arange(RATE_HZ * SECONDS) / RATE_HZ
    amplitude_m = amplitude_m if amplitude_m is not None else 1e-6 * np.exp(rng.uniform(np.log(20), np.log(150)))
    level = np.clip((t - 0.4) / 0.03, 0, 1) * (1 + 0.005 * np.sin(2 * np.pi * rng.uniform(0.1, 1) * t))
    if envelope is not None:
        level = level * envelope(t)
    tremor_m = 1e-6 * rng.uniform(3, 20) * np.sqrt(2 / 3)
    tremor = sum(tremor_m * np.sin(2 * np.pi * rng.uniform(4, 11) * t + rng.uniform(0, 6.3)) for _ in range(3))
    drift = 1e-6 * rng.uniform(-20, 20) * t
    x = (distance_m if distance_m is not None else 30e-3 + 3e-4 * rng.standard_normal()) + drift + tremor
    x = x + level * amplitude_m * np.sin(2 * np.pi * frequency_hz * t + rng.uniform(0, 6.3))
    return np.round((x + 0.5e-6 * rng.standard_normal(t.size)) / 1e-7) * 1e-7


def slipping(rng):
    begin_s, takes_s, to = rng.uniform(1.2, 1.9), rng.uniform(0.05, 0.3), rng.uniform(0.4, 0.85)
    return trial(rng, envelope=lambda t: 1 - (1 - to) * np.clip((t - begin_s) / takes_s, 0, 1))


def lost(rng):
    x = trial(rng)
    begin = rng.integers(5000, 15000)
    x[begin:begin + rng.integers(2000, 10000)] = np.nan
    return x


def clipped(rng):
    amplitude_m = 1e-6 * rng.uniform(60, 150)
    x = trial(rng, amplitude_m)
    # a rail of the converter: the upper part of each period is cut off
    return np.minimum(x, np.median(x) + rng.uniform(0.3, 0.7) * amplitude_m)


# what is wrong, the samples, and what a reason must state
FAULTS = {
    "no drive": (lambda rng: trial(rng, amplitude_m=0.0), r"no drive|drive is"),
    "230 for 225 Hz": (lambda rng: trial(rng, frequency_hz=230.0), r"tone is at 230"),
    "slipping finger": (slipping, r"steady|changes|amplitude"),
    "lost target": (lost, r"no measurements|invalid"),
    "clipped": (clipped, r"clip"),
    "wrong distance": (lambda rng: trial(rng, distance_m=30e-3 + rng.choice([-1, 1]) * rng.uniform(2.5e-3, 8e-3)),
                       r"distance"),
}


def new(folder, source, trials, *words):
    run("session", "new", folder, "--subjects", "1", "--conditions", "a", "--repeats", str(trials), "--duration",
        f"{SECONDS}s", *words, "--", *source)


def next_trial(folder, data=b""):
    done = subprocess.run([program("haptometer"), "session", "next", folder, "--json"], input=data,
                          capture_output=True, timeout=DEADLINE_S)
    check(done.returncode in (0, 3) and done.stdout, f"{done.returncode}: {done.stderr.decode()}")
    return json.loads(done.stdout)


def holds(outcome, reason):
    return outcome["verdict"] in ("CHECK", "BAD") and any(re.search(reason, one) for one in outcome["reasons"])


def missed(name, outcomes, reason):
    wrong = [outcome for outcome in outcomes if not holds(outcome, reason)]
    for outcome in wrong:
        print(f"  {name}: {outcome['verdict']} {outcome['reasons']}")
    verdicts = [outcome["verdict"] for outcome in outcomes]
    print(f"{name}: {len(outcomes) - len(wrong)} of {len(outcomes)} with the reason "
          f"({verdicts.count('BAD')} BAD, {verdicts.count('CHECK')} CHECK)", flush=True)
    return len(wrong)


def of_fault(directory, name, each):
    folder = f"{directory}/{name.replace(' ', '_')}"
    new(folder, PIPE, each, "--expect", LIMITS)
    make, reason = FAULTS[name]
    rng = np.random.default_rng(len(name))
    outcomes = []
    for _ in range(each):
        outcomes.append(next_trial(folder, make(rng).tobytes()))
    return missed(name, outcomes, reason)


def interrupted(directory, each):
    """The samples end early, or Ctrl-C comes in the middle."""
    folder = f"{directory}/interrupted"
    new(folder, PIPE, each, "--expect", LIMITS)
    rng = np.random.default_rng(1)
    outcomes = []
    for k in range(each):
        data = trial(rng).tobytes()[:int(rng.uniform(0.2, 0.9) * RATE_HZ * SECONDS) * 8]
        if k % 2 == 0:
            outcomes.append(next_trial(folder, data))
            continue
        begun = len(os.listdir(f"{folder}/trials"))
        process = subprocess.Popen([program("haptometer"), "session", "next", folder, "--json"],
                                   stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        process.stdin.write(data)
        process.stdin.flush()
        wait_for("the attempt", lambda: len(os.listdir(f"{folder}/trials")) > begun)
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        out = process.communicate(timeout=DEADLINE_S)[0]
        check(process.returncode == 130, process.returncode)
        outcomes.append(json.loads(out))
    return missed("interrupted", outcomes, r"stopped before its end|connection was lost|ended after")


def averaging_changed(directory, each):
    """The sensor is set to 2 to 16 averages after the session was planned with one."""
    folder, scene = f"{directory}/averaging", f"{directory}/scene.toml"
    with open(SCENE, encoding="utf-8") as file:
        base = file.read()
    rng = np.random.default_rng(2)
    outcomes = []

    def set_averages(averages):
        with open(scene, "w", encoding="utf-8") as file:
            file.write(base + f'\n[sensor]\nkind = "stream"\nrate_hz = 10000\nsampling_s = 1e-4\naverages = {averages}\n')

    set_averages(1)
    new(folder, ["--sensor", f"scene:{scene}", "--speed", "max"], each + 1, "--expect", LIMITS.replace(
        "distance=30mm+-2mm, ", "") + ", averaging=1")
    for k in range(each + 1):
        if k > 0:
            set_averages(int(rng.integers(2, 17)))
        outcomes.append(next_trial(folder))
    check(not holds(outcomes[0], "averag"), f"one average is as planned: {outcomes[0]}")
    return missed("averaging changed", outcomes[1:], r"averag")


def good_session(directory, seed, trials):
    """Sessions of 96: 8 subjects, 4 conditions, 3 repeats, whose RMS scatter by 4 %. Returns what is not GOOD."""
    folder = f"{directory}/good_{seed}"
    rng = np.random.default_rng(1000 + seed)
    run("session", "new", folder, "--subjects", "8", "--conditions", "a,b,c,d", "--repeats", "3", "--seed", str(seed),
        "--duration", f"{SECONDS}s", "--expect", LIMITS, "--", *PIPE)
    levels, others = {}, []
    cell = json.loads(run("session", "status", folder, "--json").stdout)["next"]
    for _ in range(trials):
        level = levels.setdefault((cell["subject"], cell["condition"]),
                                  1e-6 * np.exp(rng.uniform(np.log(20), np.log(150))))
        outcome = next_trial(folder, trial(rng, level * np.exp(0.04 * rng.standard_normal())).tobytes())
        cell = outcome["next"]
        if outcome["verdict"] != "GOOD":
            others.append(outcome["reasons"])
    return others


def main():
    words = argparse.ArgumentParser()
    words.add_argument("programs", nargs="?")
    words.add_argument("--each", type=int, default=20)
    words.add_argument("--good", type=int, default=1000)
    words.add_argument("--jobs", type=int, default=os.cpu_count())
    given = words.parse_args()
    if given.programs:
        os.environ["HAPTOMETER_PROGRAMS"] = given.programs
    with tempfile.TemporaryDirectory() as directory, concurrent.futures.ThreadPoolExecutor(given.jobs) as jobs:
        faults = [jobs.submit(of_fault, directory, name, given.each) for name in FAULTS]
        faults += [jobs.submit(what, directory, given.each) for what in (interrupted, averaging_changed)]
        good = [jobs.submit(good_session, directory, seed, min(96, given.good - done))
                for seed, done in enumerate(range(0, given.good, 96))]
        wrong = sum(fault.result() for fault in faults)
        others = [reasons for session in good for reasons in session.result()]
    for reasons in others:
        print(f"  not GOOD: {reasons}")
    print(f"good trials: {given.good - len(others)} of {given.good} GOOD")
    check(wrong == 0, f"{wrong} faults were not found")
    check(len(others) <= 0.02 * given.good, f"{len(others)} good trials are not GOOD")


main()
