#!/usr/bin/python3
"""What an answer that knows its error costs over the cheapest single run within the accuracy.

  tests/long/answer_cost.py build/release/bin [--count 60]

Random scenes of the classes with smooth effects (a stiffening spring, a coil that heats) of accuracies.py, by
bench/smooth_answer_cost.cc at 1e-2 to 1e-10. Prints for each accuracy the 10 %, 50 % and 90 % quantiles of the ratio, and
status 1 where an answer's error exceeds its estimate, or its estimate the accuracy. Nothing should run beside it.
"""
import argparse
import pathlib
import statistics
import subprocess
import sys
import tempfile

import accuracies

CLASSES = (["stiffening"], ["coil_heating"])
ROUNDING = 2e-13  # of the reference run


def write_scenes(folder, count):
    """Scene files of the first `count` seeds of these classes."""
    paths = []
    seed = 0
    while len(paths) < count:
        effects, _, scene, volts = accuracies.scene_of(seed)
        seed += 1
        if effects not in CLASSES:
            continue
        place = folder / f"{seed:04d}"
        place.mkdir()
        (place / "scene.toml").write_text(accuracies.toml_of(scene), encoding="utf-8")
        if volts:
            (place / "drive.csv").write_text("voltage_v\n" + "\n".join(map(repr, volts)) + "\n", encoding="utf-8")
        paths.append(str(place / "scene.toml"))
    return paths


def main():
    options = argparse.ArgumentParser()
    options.add_argument("bin", type=pathlib.Path)
    options.add_argument("--count", type=int, default=60)
    given = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        scenes = write_scenes(pathlib.Path(folder), given.count)
        run = subprocess.run([given.bin / "smooth_answer_cost", *scenes], capture_output=True, text=True, check=True)
    ratios, wrong = {}, 0
    for line in run.stdout.splitlines():
        accuracy, answer_s, best_s, estimate, error = map(float, line.split())
        ratios.setdefault(accuracy, []).append(answer_s / best_s)
        wrong += error > max(estimate, ROUNDING) or estimate > accuracy
    for accuracy, values in ratios.items():
        tenths = statistics.quantiles(values, n=10)
        print(f"{accuracy:g}: {statistics.median(values):.2f} times the best single run; "
              f"10 to 90 %: {tenths[0]:.2f} to {tenths[-1]:.2f}")
    print(f"{given.count} scenes, {wrong} answers beyond their estimate or the accuracy")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
