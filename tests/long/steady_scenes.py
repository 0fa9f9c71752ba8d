#!/usr/bin/env python3
"""Steady motions: `simulate` without a duration against long transients of the independent integrator.

    tests/long/steady_scenes.py build/release/bin [--count 300] [--first 0] [--workers 2] [--verbose]

Two thirds of the scenes have stops or contact that can be lost. Each is played from rest by scene_reference until
its mean square over two following windows of whole periods agrees to 1e-9 or 6400 periods are over; `simulate` has
to give the RMS and the mover's peak of that motion, an average with a standard uncertainty that holds it, or refuse.
"""
import argparse
import collections
import concurrent.futures
import json
import math
import os
import random
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "sim", "reference"))
import scene_reference as reference  # noqa: E402

LIMITED = [["rigid_stops"], ["compliant_stops"], ["contact_loss"], ["compliant_stops", "gravity"],
           ["rigid_stops", "contact_loss"], ["compliant_stops", "contact_loss"]]
OTHERS = [["stiffening"], ["coil_heating"], ["gravity"]]


def steady_scene(seed):
    draw = random.Random(1_000_003 * (seed + 1))
    effects = draw.choice(LIMITED) if seed % 3 else draw.choice(OTHERS)
    scene = reference.random_scene(seed, effects=effects, tolerance=1e-6)
    scene["effects"]["inductance"] = draw.random() < 0.3
    if "coil_heating" in effects:  # warm within some periods, so that a transient can be played to its end
        scene["coil_heating"] = {"heat_capacity_j_per_k": 2e-4 / scene["drive"]["frequency_hz"] * 225,
                                 "thermal_resistance_k_per_w": 60.0}
    return scene


def recurrence(states, limit=1e-7):
    """After how many periods the last states repeat themselves; 0: not within 64."""
    scale = max(max(abs(x) for x in states[-200:]), 1e-30)
    for k in range(1, 65):
        if all(abs(states[-1 - j] - states[-1 - j - k]) < limit * scale for j in range(k)):
            return k
    return 0


def transient(program, scene, seconds):
    """RMS of the motion that the start leads to, after how many periods it repeats, its mover's peak (of a motion
    that repeats itself), what all is known to; None where the integrator stalls."""
    def play(periods, window):
        scene["run"]["duration_s"] = periods / scene["drive"]["frequency_hz"]
        text = reference.reference_lines(scene, window / scene["drive"]["frequency_hz"], strobe=True, tolerance=1e-18)
        return reference.run_reference(program, [text], seconds)[0]

    periods = 400
    while True:
        answer = play(periods, 1)
        if answer.get("stalled"):
            return None
        squares = answer["period_mean_square_m2"]
        k = recurrence(answer["period_mover_m"]) if len(squares) > 300 else 0
        window = len(squares) // 4 if k == 0 else k
        last, before = sum(squares[-window:]) / window, sum(squares[-2 * window:-window]) / window
        known = abs(last - before) / (2 * last)
        if (k > 0 and known < 1e-9) or periods >= 6400:
            batches = [sum(squares[-window + b * window // 8:][:window // 8]) / (window // 8) for b in range(8)] if k == 0 else []
            spread = 0.0
            if batches:
                mean = sum(batches) / 8
                spread = math.sqrt(sum((b - mean) ** 2 for b in batches) / 7 / 8) / (2 * mean)
            peak = None if k == 0 else (answer if k == 1 else play(periods, k))["mover_peak_m"]
            return {"rms": math.sqrt(last), "period": k, "peak": peak, "known": max(known, spread)}
        periods *= 4


def judge(arguments):
    programs, program, seed, seconds = arguments
    scene = steady_scene(seed)
    result = {"seed": seed, "effects": [k for k, v in scene["effects"].items() if v]}
    without = {table: values for table, values in scene.items() if table != "run"}
    without["run"] = {"tolerance": scene["run"]["tolerance"]}
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scene.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(reference.toml_of(without))
        try:
            done = subprocess.run([os.path.join(programs, "haptometer"), "simulate", path, "--json"],
                                  capture_output=True, text=True, timeout=seconds)
        except subprocess.TimeoutExpired:
            return result | {"verdict": "time"}
    try:
        truth = transient(program, scene, seconds)
    except subprocess.TimeoutExpired:
        return result | {"verdict": "reference: time"}
    if truth is None:
        said = "refused" if done.returncode else "answered"
        return result | {"verdict": f"reference stalls, {said}", "text": (done.stderr + done.stdout)[-300:]}
    result |= truth
    if done.returncode != 0:
        chaos = truth["period"] == 0
        return result | {"verdict": "refused, no period in the reference" if chaos else f"refused, status {done.returncode}",
                         "text": (done.stderr + done.stdout)[-300:]}
    answer = json.loads(done.stdout)
    stated = answer["error_estimate"] or 0.0
    average = answer.get("average") or {}
    error = average.get("skin_rms_standard_uncertainty_m")
    off = abs(answer["skin_rms_m"] - truth["rms"]) / truth["rms"]
    periodic = answer.get("periodic") or {}
    result |= {"answer": answer["skin_rms_m"], "off": off, "answered_period": periodic.get("drive_periods"), "error": error}
    if error is not None:
        allowed = 4 * math.hypot(error / answer["skin_rms_m"], truth["known"])
        return result | {"verdict": "average holds" if off <= allowed else "AVERAGE MISSES"}
    allowed = max(stated, 1e-6) + 10 * truth["known"]
    peak_off = abs(answer["mover_peak_m"] / truth["peak"] - 1) if truth["peak"] else 0.0
    verdict = "WRONG" if off > allowed else "holds" if peak_off <= allowed else "WRONG PEAK"
    return result | {"peak_off": peak_off, "verdict": verdict}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("programs")
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=300, help="the longest that a scene may take")
    parser.add_argument("--verbose", action="store_true")
    options = parser.parse_args()
    counts = collections.Counter()
    seeds = range(options.first, options.first + options.count)
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(options.workers) as pool:
        program = reference.build_reference(folder)
        for result in pool.map(judge, [(options.programs, program, seed, options.seconds) for seed in seeds]):
            counts[result["verdict"]] += 1
            if options.verbose or "holds" not in result["verdict"]:
                print(json.dumps(result), flush=True)
    print(", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items())))
    return 1 if counts["WRONG"] + counts["WRONG PEAK"] + counts["AVERAGE MISSES"] else 0


if __name__ == "__main__":
    sys.exit(main())
