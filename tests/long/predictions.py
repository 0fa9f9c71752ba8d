#!/usr/bin/env python3
"""Prices that `cost` predicts against those that it measures: time and error of random scenes.

    tests/long/predictions.py build/release/bin [--count 100] [--first 0] [--verbose]

Scenes are those of nonlinear_scenes.py, each at an accuracy of its own from 1e-2 to 1e-10, every third one
without effects and every seventh one without a duration. Bars: the time within a factor of two in 90 of 100;
the predicted error holds what the answer states in all, and is within a factor of 100 of it, or of 1e-13, in 90.
"""
import argparse
import json
import os
import random
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "sim", "reference"))
import scene_reference as reference  # noqa: E402

ROUNDING = 1e-13  # below it a bound need not follow
DEADLINE_S = 300


def scene_text(seed):
    scene = reference.random_scene(seed)
    if seed % 3 == 0:
        scene["effects"] = {}
    if seed % 7 == 0:
        del scene["run"]["duration_s"]
    return reference.toml_of(scene)


def priced(program, seed):
    """The program's own method for a scene, or None where it is refused."""
    accuracy = 10 ** random.Random(seed).uniform(-10, -2)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scene.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(scene_text(seed))
        done = subprocess.run([program, "cost", "skin-rms", "--scene", path, "--accuracy", f"{accuracy:.3g}",
                               "--measure", "--json"], capture_output=True, text=True, timeout=DEADLINE_S)
    if done.returncode == 3:
        return None
    if done.returncode != 0:
        sys.exit(f"seed {seed}: {done.stderr}")
    return next(method for method in json.loads(done.stdout)["methods"] if not method["is_peer"])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("programs")
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--verbose", action="store_true")
    given = parser.parse_args()
    program = os.path.join(os.path.abspath(given.programs), "haptometer")
    in_time = bounded = near = answered = 0
    for seed in range(given.first, given.first + given.count):
        own = priced(program, seed)
        if own is None:
            continue
        answered += 1
        ratio = own["predicted_s"] / own["measured_s"]
        stated, bound = own["measured_error"], own["predicted_error"]
        in_time += 0.5 <= ratio <= 2
        bounded += stated <= bound
        near += bound <= 100 * max(stated, ROUNDING)
        if given.verbose:
            print(f"{seed}: {own['method']}: time {ratio:.2f} of {own['measured_s']:.3g} s, error {bound:.2g} for {stated:.2g}")
    print(f"{answered} of {given.count} answered: time within a factor of 2 in {in_time}, the bound holds in {bounded} "
          f"and is within a factor of 100 in {near}")
    return 0 if bounded == answered and min(in_time, near) >= 0.9 * answered else 1


if __name__ == "__main__":
    sys.exit(main())
