#!/usr/bin/python3
"""The intervals that `acquire --advise` and `plan-drop-test` promise, against those that simulated experiments attain.

  advise.py build/release/bin [--seed 1] [--vibrations 220] [--drops 80] [--jobs 2] [--table FILE.csv]

A vibration: a question drawn at random (band, drive, RMS, accuracy) is put to `acquire --advise`. One of its routes
that answers is drawn, and a record of the promised length is made as the sensor makes it: raw samples with white noise,
averaged, held by the amplifier or by the unit's buffer, rounded to its steps. It goes through `acquire --sensor pipe`
with the route's own averaging, and `analyze`. A drop test: constants and a wish for one of Kv, Bv, Km are drawn, planned
by `plan-drop-test --want`, and as many drops as it asks for are summed up with the recorder's noise and steps and given
to `fit-lra` by the plan's own command. Bar: half of the 95 % interval within 25 % of the promised one in 270 of 300; an
experiment without an answer counts as a miss. Written without the program's code.
"""
import argparse
import collections
import concurrent.futures
import csv
import json
import pathlib
import shlex
import subprocess
import sys
import tempfile

import numpy as np

RAW_NOISE_M = 11e-6       # of an IL-030, one sample without averaging
DAQ_NOISE_M = 5e-8        # of a converter of 16 bits over 20 V: a fifth of its step of 0.3 um
IL_STEP_M, STREAM_STEP_M = 1e-6, 1e-7
REFRESH_S = {"keyence-il": 7e-3, "keyence-en1": 7.8e-3}
LONGEST_S = {"pipe": 60, "stream": 40, "keyence-il": 600, "keyence-en1": 600}
WITHIN = 0.25


def run(words, **more):
    return subprocess.run([str(word) for word in words], capture_output=True, **more)


def log_uniform(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def settings_of(text):
    """The route's options: {"sensor": ["pipe"], "set": ["sampling=1ms", "averaging=8"], ...}."""
    words = collections.defaultdict(list)
    parts = text.split()
    for name, value in zip(parts[::2], parts[1::2]):
        words[name[2:]].append(value)
    return words


# ---------------------------------------------------------------- a vibration

def ask(program, rng):
    """A question and the routes that answer it."""
    slow = rng.uniform() < 0.25
    lower, upper = (0.5, log_uniform(rng, 6, 15)) if slow else (log_uniform(rng, 8, 40), log_uniform(rng, 250, 550))
    # where the filter takes 1e-4 at most
    drive = rng.uniform(2.2 * lower, 0.5 * upper)
    question = {"band": f"{lower:.3g}-{upper:.4g}Hz", "drive": f"{drive:.6g}Hz",
                "rms": f"{log_uniform(rng, 4, 200):.4g}um", "accuracy": f"{log_uniform(rng, 0.3, 5):.3g}%",
                "noise": f"{log_uniform(rng, 0.3, 8):.3g}um"}
    words = [word for name, value in question.items() for word in (f"--{name}", value)]
    answer = json.loads(run([program, "acquire", "--advise", *words, "--json"], check=True).stdout)
    routes = []
    for route in answer["routes"]:
        kind = settings_of(route["settings"])["sensor"][0]
        if route["answers"] and route["length_of_record_s"] and route["length_of_record_s"] <= LONGEST_S.get(kind, 0):
            routes.append((kind, route))
    return question, routes


def il_motion(rng, question, count, sampling_s, averages):
    """Raw samples of an IL-030, and their moving mean."""
    drive, rms = float(question["drive"][:-2]), float(question["rms"][:-2]) * 1e-6
    times = sampling_s * np.arange(count + averages)
    raw = np.sqrt(2) * rms * np.sin(2 * np.pi * drive * times + rng.uniform(0, 2 * np.pi))
    raw += RAW_NOISE_M * rng.standard_normal(len(times))
    sums = np.concatenate([[0], np.cumsum(raw)])
    return (sums[averages:] - sums[:-averages])[:count] / averages


def record(rng, question, kind, route):
    """(samples in m, options of acquire) of the route's length."""
    set_to = settings_of(route["settings"])
    rate, seconds = route["rate_hz"], route["length_of_record_s"]
    at = np.arange(int(round(rate * seconds))) / rate
    if kind == "stream":
        drive, rms = float(question["drive"][:-2]), float(question["rms"][:-2]) * 1e-6
        noise = float(question["noise"][:-2]) * 1e-6
        values = np.sqrt(2) * rms * np.sin(2 * np.pi * drive * at + rng.uniform(0, 2 * np.pi))
        values += noise * rng.standard_normal(len(at))
        return np.round((values + 1e-3 * rng.uniform()) / STREAM_STEP_M) * STREAM_STEP_M, ["--averaging", "1"]
    if kind == "pipe":
        # "IL-030, analog output and a DAQ, 0.33 ms, 4 averages": held, and sampled by the DAQ
        sampling_s, averages = (float(part.split()[0]) for part in route["name"].split(", ")[-2:])
        sampling_s *= 1e-3
        mean = il_motion(rng, question, int(seconds / sampling_s) + 2, sampling_s, int(averages))
        values = mean[np.floor((at + rng.uniform() * sampling_s) / sampling_s).astype(int)]
        values = values + DAQ_NOISE_M * rng.standard_normal(len(at))
        return values, ["--averaging", set_to["averaging"][0], "--sampling", set_to["sampling"][0]]
    # polled: the buffer is refilled at k * refresh with the latest mean
    il = dict(pair.split("=") for pair in set_to["set"])
    sampling_s, averages = float(il["sampling"][:-2]) * 1e-3, int(il["averaging"])
    mean = il_motion(rng, question, int(seconds / sampling_s) + 100, sampling_s, averages)
    filled = np.floor((at + rng.uniform() * REFRESH_S[kind]) / REFRESH_S[kind]) * REFRESH_S[kind]
    values = mean[np.floor(filled / sampling_s + 1e-9).astype(int)]
    words = ["--averaging", il["averaging"]] + (["--sampling", il["sampling"]] if averages > 1 else [])
    return np.round((values + 1e-3 * rng.uniform()) / IL_STEP_M) * IL_STEP_M, words


def vibration(program, folder, seed):
    rng = np.random.default_rng(seed)
    while True:
        question, routes = ask(program, rng)
        if routes:
            break
    # each kind of route alike
    kinds = sorted({kind for kind, _ in routes})
    kind = kinds[rng.integers(len(kinds))]
    of_kind = [route for its_kind, route in routes if its_kind == kind]
    route = of_kind[rng.integers(len(of_kind))]
    trials = [folder / f"{name}{seed}.bin" for name in ("on", "off")[:2 if route["floor_record_s"] else 1]]
    for trial in trials:
        rms = question["rms"] if trial is trials[0] else "0um"
        values, words = record(rng, {**question, "rms": rms}, kind, route)
        run([program, "acquire", "--sensor", "pipe", "--format", "f64", "--rate", f"{route['rate_hz']!r}Hz",
             "--channels", "displacement:m", *words, "-o", trial], input=values.astype("<f8").tobytes(), check=True)
    floor = ["--floor", trials[1]] if len(trials) > 1 else []
    analyzed = run([program, "analyze", trials[0], *floor, "--band", question["band"], "--json"])
    answer = json.loads(analyzed.stdout)["trials"][0]
    for trial in trials:
        trial.unlink()
    rms_m, interval = answer["band_rms_m"], answer["band_rms_interval_95_m"]
    truth = float(question["rms"][:-2]) * 1e-6
    attained = (interval[1] - interval[0]) / 2 / rms_m if answer["answered"] and interval else None
    # what of the truth is in no interval is stated apart: the age
    margin = route["age_relative_error"] * truth
    holds = attained is not None and interval[0] - margin <= truth <= interval[1] + margin
    return {"seed": seed, "kind": kind, "name": route["name"], "promised": route["predicted_relative_half_interval"],
            "attained": attained, "holds": holds,
            "about": " ".join(question.values()) + f" {route['length_of_record_s']} s {route['limited_by']}",
            "why": "; ".join(answer["reasons"])}


# ---------------------------------------------------------------- a drop test

def ringing(t, plan, truth, load_ohm, speed_v):
    """Terminal voltage t behind the blow, without the coil's inductance: Km v times the load's share."""
    share = 1.0 if load_ohm is None else load_ohm / (load_ohm + truth["resistance"])
    damping = truth["Bv"] + (0 if load_ohm is None else truth["Km"] ** 2 / (truth["resistance"] + load_ohm))
    decay = damping / (2 * truth["mass"])
    angular = np.sqrt(truth["Kv"] / truth["mass"] - decay ** 2)
    shape = np.exp(-decay * t) * (np.cos(angular * t) - decay / angular * np.sin(angular * t))
    return -truth["Km"] * share * speed_v * shape


def planned(program, rng):
    """A plan that reaches its wish, with what was drawn."""
    while True:
        f0, quality, km = rng.uniform(120, 280), log_uniform(rng, 15, 80), log_uniform(rng, 0.5, 2.5)
        mass, resistance = rng.uniform(0.9e-3, 3e-3), rng.uniform(10, 40)
        kv = mass * (2 * np.pi * f0) ** 2
        truth = {"mass": mass, "resistance": resistance, "Kv": kv, "Bv": np.sqrt(kv * mass) / quality, "Km": km}
        constant = ("Kv", "Bv", "Km")[rng.integers(3)]
        words = ["--resistance", f"{resistance!r}ohm", "--f0", f"{f0!r}Hz", "--guess", f"Q {quality!r}", "--guess",
                 f"Km {km!r}N/A", "--moving-mass", f"{1e3 * mass:.9f}g+-{1e3 * mass * rng.uniform(5e-4, 5e-3):.9f}g",
                 "--want", f"{constant} {log_uniform(rng, 0.3, 4):.3g}%"]
        plan = run([program, "plan-drop-test", *words, "--json"])
        if plan.returncode != 0:
            continue
        plan = json.loads(plan.stdout)
        wish = plan["wishes"][0]
        # two drops of each kind at least: one shows nothing of how they repeat
        taps = max(2, wish["open_drops_needed"], wish["loaded_drops_needed"])
        plan = json.loads(run([program, "plan-drop-test", *words, "--taps", taps, "--json"], check=True).stdout)
        return constant, truth, plan


def drop_test(program, folder, seed):
    rng = np.random.default_rng(seed)
    constant, truth, plan = planned(program, rng)
    recorder, load_ohm = plan["recorder"], plan["load_ohm"]["value"]
    speed = plan["guesses"]["speed_m_per_s"]
    home = folder / f"d{seed}"
    home.mkdir()
    step_s = 1 / recorder["rate_hz"]
    behind = int(recorder["length_s"] / step_s)
    for name, count, ohm in (("open", plan["open_drops"], None), ("loaded", plan["loaded_drops"], load_ohm)):
        for k in range(count):
            times = step_s * np.arange(-int(recorder["pre_trigger_s"] / step_s), behind) + step_s * rng.uniform()
            volts = np.where(times > 0, ringing(np.maximum(times, 0), plan, truth, ohm, speed * rng.uniform(0.95, 1.05)),
                             0)
            volts += 0.3 * recorder["step_v"] * rng.uniform() + recorder["noise_v"] * rng.standard_normal(len(times))
            volts = np.round(volts / recorder["step_v"]) * recorder["step_v"]
            lines = [f"{t:.9e},{v:.7e}" for t, v in zip(times, volts)]
            (home / f"{name}{k}.csv").write_text("time_s,voltage_v\n" + "\n".join(lines) + "\n")
    words = shlex.split(plan["command"])[1:]
    files = [sorted(map(str, home.glob(word))) if "*" in word else [word] for word in words]
    answered = run([program, *[word for group in files for word in group], "--json"], cwd=home)
    answer = json.loads(answered.stdout) if answered.stdout else None
    promised = 1.96 * plan["relative_standard_uncertainty"][constant]["combined"]
    estimate = answer["parameters"][constant] if answer else {}
    known = bool(estimate.get("determined"))
    lower, upper = (estimate["lower_95"], estimate["upper_95"]) if known else (None, None)
    return {"seed": seed, "kind": "drops " + constant, "name": f"{plan['open_drops']} + {plan['loaded_drops']} drops",
            "promised": promised, "attained": (upper - lower) / 2 / estimate["value"] if known else None,
            "holds": known and lower <= truth[constant] <= upper,
            "about": plan["relative_standard_uncertainty"][constant]["limited_by"],
            "why": answered.stderr.decode()[-200:] if not known else ""}


# ---------------------------------------------------------------- all

def attempt(work):
    make, program, folder, seed = work
    return make(program, folder, seed)


def is_kept(row):
    return row["attained"] is not None and abs(row["attained"] / row["promised"] - 1) <= WITHIN


def report(rows):
    kinds = collections.defaultdict(list)
    for row in rows:
        kinds[row["kind"]].append(row)
    print(f"{'kind':14} {'all':>4} {'within 25 %':>12} {'holds':>6}  attained / promised: 5 %, 50 %, 95 %")
    for kind, group in sorted(kinds.items()) + [("all", rows)]:
        ratios = [row["attained"] / row["promised"] for row in group if row["attained"] is not None]
        spread = ", ".join(f"{value:.2f}" for value in np.quantile(ratios, [0.05, 0.5, 0.95])) if ratios else "-"
        print(f"{kind:14} {len(group):4} {sum(map(is_kept, group)):12} {sum(row['holds'] for row in group):6}  {spread}")
    for row in rows:
        if not is_kept(row):
            print(f"  missed: seed {row['seed']} {row['name']} ({row['about']}): promised {row['promised']:.4g}, "
                  f"attained {row['attained']} {row['why']}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--vibrations", type=int, default=220)
    parser.add_argument("--drops", type=int, default=80)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--table", type=pathlib.Path)
    asked = parser.parse_args()
    program = (asked.programs / "haptometer").resolve()
    with tempfile.TemporaryDirectory() as folder:
        first = 100_000 * asked.seed
        work = [(vibration, program, pathlib.Path(folder), first + k) for k in range(asked.vibrations)]
        work += [(drop_test, program, pathlib.Path(folder), first + 50_000 + k) for k in range(asked.drops)]
        with concurrent.futures.ProcessPoolExecutor(asked.jobs) as pool:
            rows = list(pool.map(attempt, work))
    if asked.table:
        with asked.table.open("w", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)
    report(rows)
    kept = sum(map(is_kept, rows))
    print(f"{kept} of {len(rows)} within {WITHIN:.0%} of the promised interval; bar {0.9 * len(rows):.0f}")
    return 0 if kept >= 0.9 * len(rows) else 1


if __name__ == "__main__":
    sys.exit(main())
