#!/usr/bin/env python3
"""Random scenes of all pairs of effects: `simulate` against the independent integrator.

    tests/long/nonlinear_scenes.py build/release/bin [--count 1000] [--first 0] [--workers 2] [--verbose]

For each scene the largest relative deviation of the run's numbers from the reference is compared with
the error that `simulate` states. The reference itself is run three times: as it is, with a thousand
times looser steps, and with the drive's amplitude 1e-15 larger; what it cannot say itself (chaos) is
counted apart, and there `simulate` has to say so, too.
"""
import argparse
import collections
import concurrent.futures
import json
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "sim", "reference"))
import scene_reference as reference  # noqa: E402

QUANTITIES = ["skin_rms_m", "case_rms_m", "current_rms_a", "power_w", "mover_peak_m"]


def deviation(measured, true):
    """The largest relative deviation of the run's numbers, and of which."""
    worst, which = 0.0, ""
    for key in QUANTITIES:
        if true[key] == 0 and measured[key] == 0:
            continue
        off = abs(measured[key] - true[key]) / abs(true[key]) if true[key] != 0 else float("inf")
        if not off <= worst:
            worst, which = off, key
    return worst, which


def judge(arguments):
    programs, program, seed, seconds = arguments
    scene = reference.random_scene(seed)
    result = {"seed": seed, "effects": [k for k, v in scene["effects"].items() if v], "tolerance": scene["run"]["tolerance"]}
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scene.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(reference.toml_of(scene))
        try:
            done = subprocess.run([os.path.join(programs, "haptometer"), "simulate", path, "--json"],
                                  capture_output=True, text=True, timeout=seconds)
        except subprocess.TimeoutExpired:
            return result | {"verdict": "time"}
    if done.returncode == 3:
        return result | {"verdict": "refused", "text": done.stderr.strip()[:200]}
    if done.returncode != 0:
        return result | {"verdict": f"status {done.returncode}", "text": done.stderr.strip()[:200]}
    answer = json.loads(done.stdout)
    run = answer["run"]
    if run is None:
        return result | {"verdict": "no run"}
    window = run["window_s"][1] - run["window_s"][0]
    texts = [reference.reference_lines(scene, window),
             reference.reference_lines(scene, window, tolerance=1e-17),
             reference.reference_lines(scene, window, amplitude_factor=1 + 2e-15)]
    try:
        truth, loose, moved = reference.run_reference(program, texts)
    except subprocess.TimeoutExpired:
        return result | {"verdict": "reference: time"}
    if truth["stalled"]:
        return result | {"verdict": "reference: stalled"}
    own = max(deviation(loose, truth)[0], deviation(moved, truth)[0])
    off, which = deviation(run, truth)
    force_off = 0.0
    least = answer.get("contact_force_least_n")
    if least is not None and scene["effects"].get("contact_loss") is None and "preload_n" not in scene["skin"]:
        scale = max(abs(truth["contact_force_least_n"]), 1e-12)
        force_off = abs(least - truth["contact_force_least_n"]) / scale
    stated = run["error_estimate"]
    result |= {"off": off, "which": which, "force_off": force_off, "stated": stated, "reference": own,
               "events": truth["events"], "beyond": run["known_until_s"]}
    if own > 1e-2 * max(off, 1e-12) and own > 1e-9:
        verdict = "unpredictable"
    elif stated is None:
        verdict = "not stated"
    elif off <= stated:
        verdict = "holds"
    else:
        verdict = "VIOLATED"
    return result | {"verdict": verdict}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("programs")
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=300, help="the longest that a scene may take")
    parser.add_argument("--verbose", action="store_true")
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.count)
    counts = collections.Counter()
    worst = []
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(options.workers) as pool:
        program = reference.build_reference(folder)
        for result in pool.map(judge, [(options.programs, program, seed, options.seconds) for seed in seeds]):
            counts[result["verdict"]] += 1
            if options.verbose or result["verdict"] not in ("holds", "refused"):
                print(json.dumps(result), flush=True)
            if result["verdict"] == "holds" and result["stated"] > 0:
                worst.append(result["stated"])
    print(", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items())))
    return 1 if counts["VIOLATED"] else 0


if __name__ == "__main__":
    sys.exit(main())
