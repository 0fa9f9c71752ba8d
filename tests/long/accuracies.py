#!/usr/bin/env python3
"""`simulate --accuracy` over random scenes of all classes, against the independent integrator.

    tests/long/accuracies.py build/release/bin [--count 300] [--first 0] [--workers 2] [--verbose]

Classes: what limits or bends the motion (nothing, rigid and compliant stops, contact, stiffening,
heating, and stiffening with heating as "auto" that change little) under each kind of drive (sine,
tones, bursts, files). Of each scene every accuracy from 1e-2 to 1e-10 is asked for:

  holds          every number lies within the accuracy, the RMS values, power and peaks of the run
  VIOLATED       one does not
  refused        no answer to that accuracy, which is said
  unpredictable  the reference itself moves by more where the drive is changed by 2e-15

Then `--explain` times each accuracy in one process, and it is counted how often a looser one took
more than 1.25 times as long as a tighter one and 0.2 ms (noise of the machine).
"""
import argparse
import collections
import concurrent.futures
import json
import os
import random
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "sim", "reference"))
import scene_reference as reference  # noqa: E402

ACCURACIES = [1e-2, 1e-4, 1e-6, 1e-8, 1e-10]
EFFECTS = [[], ["rigid_stops"], ["compliant_stops"], ["contact_loss"], ["stiffening"], ["coil_heating"], ["negligible"]]
DRIVES = ["sine", "tones", "burst", "samples"]
QUANTITIES = ["skin_rms_m", "case_rms_m", "current_rms_a", "power_w", "mover_peak_m", "mover_peak_of_run_m"]
# of the reference's own steps
OWN_ERROR = 1e-13


def scene_of(seed):
    """Effects, drive and the scene, its run 12 to 25 periods long; the file's voltages apart."""
    draw = random.Random(seed + 40_000)
    effects = EFFECTS[seed % len(EFFECTS)]
    kind = DRIVES[seed // len(EFFECTS) % len(DRIVES)]
    small = effects == ["negligible"]
    scene = reference.random_scene(seed, effects=["stiffening", "coil_heating"] if small else effects,
                                   periods=draw.uniform(12, 25))
    if small:
        scene["stiffening"]["cubic_n_per_m3"] = reference.number(
            scene["stiffening"]["cubic_n_per_m3"] * 10 ** -draw.uniform(3, 9))
        scene["coil_heating"]["heat_capacity_j_per_k"] = reference.number(10 ** draw.uniform(2, 6))
        scene["effects"] |= {"stiffening": "auto", "coil_heating": "auto"}
    if not effects:
        scene["effects"]["gravity"] = "auto"  # which moves the centre only; a run is then reported
    volts = redrive(scene, kind, draw)
    return effects, kind, scene, volts


def redrive(scene, kind, draw):
    """Gives the scene another drive of the same size; the voltages of a file, or None."""
    drive, run = scene["drive"], scene["run"]
    amplitude, frequency = drive["amplitude_v"], drive["frequency_hz"]
    if kind == "tones":
        scene["drive"] = {"kind": "tones", "tone": [
            {"amplitude_v": reference.number(amplitude * draw.uniform(0.2, 0.6)),
             "frequency_hz": reference.number(frequency * draw.uniform(0.5, 1.7)),
             "phase_rad": reference.number(draw.uniform(-3, 3))} for _ in range(draw.choice([2, 3]))]}
        run["start"] = "rest"
    if kind == "burst":
        length = run["duration_s"]
        rise, hold = (reference.number(length * draw.uniform(0.05, 0.3)) for _ in range(2))
        scene["drive"] = drive | {"kind": "burst", "start_s": reference.number(length * draw.uniform(0, 0.1)),
                                  "rise_s": draw.choice([0, rise]), "hold_s": hold, "fall_s": draw.choice([0, rise])}
    if kind == "samples":
        rate = reference.number(frequency * draw.uniform(3, 20))
        volts = [reference.number(draw.gauss(0, amplitude)) for _ in range(int(run["duration_s"] * rate * 0.9) + 2)]
        scene["drive"] = {"kind": "samples", "rate_hz": rate, "file": "drive.csv"}
        return volts
    return None


def toml_of(scene):
    """scene.toml, the tones as tables of their own."""
    tones = scene["drive"].get("tone", [])
    plain = scene | {"drive": {key: value for key, value in scene["drive"].items() if key != "tone"}}
    text = reference.toml_of(plain)
    for tone in tones:
        text += "[[drive.tone]]\n" + "".join(f"{key} = {value!r}\n" for key, value in tone.items())
    return text


def reference_text(scene, volts, window_s, factor):
    """The scene as scene_reference reads it; factor: of all voltages."""
    drive = scene["drive"]
    on = {key: bool(value) for key, value in scene["effects"].items()}
    sine = {"kind": "sine", "amplitude_v": drive.get("amplitude_v", 0.0), "frequency_hz": drive.get("frequency_hz", 1.0)}
    lines = reference.reference_lines(scene | {"drive": sine, "effects": on}, window_s).split("\n")
    lines = [line for line in lines if line and not line.startswith("drive")]
    amplitude = sine["amplitude_v"] * factor
    if drive["kind"] == "sine":
        lines.append(f"drive {amplitude!r} {drive['frequency_hz']!r}")
    for tone in drive.get("tone", []):
        lines.append(f"drive {tone['amplitude_v'] * factor!r} {tone['frequency_hz']!r} {tone['phase_rad']!r}")
    if drive["kind"] == "burst":
        phase = -2 * 3.141592653589793238 * drive["frequency_hz"] * drive["start_s"]
        lines.append(f"drive {amplitude!r} {drive['frequency_hz']!r} {phase!r}")
        at = drive["start_s"]
        knots = [(at, 0.0)]
        for length, level in ((drive["rise_s"], 1.0), (drive["hold_s"], 1.0), (drive["fall_s"], 0.0)):
            at += length
            knots.append((at, level))
        lines += [f"envelope {when!r} {level!r}" for when, level in knots]
    if volts:
        rate = drive["rate_hz"]
        lines += [f"volts {k / rate!r} {volt * factor!r}" for k, volt in enumerate(volts)]
        lines.append(f"volts {(len(volts) - 1) / rate!r} 0.0")
    return "\n".join(lines) + "\n\n"


def deviation(measured, true):
    """The largest relative deviation of the run's numbers, and of which."""
    worst, which = 0.0, ""
    for key in QUANTITIES:
        if true[key] == measured[key]:
            continue
        off = abs(measured[key] - true[key]) / abs(true[key]) if true[key] != 0 else float("inf")
        if not off <= worst:
            worst, which = off, key
    return worst, which


def run_program(programs, folder, more):
    return subprocess.run([os.path.join(programs, "haptometer"), "simulate", os.path.join(folder, "scene.toml"), "--json",
                           *more], capture_output=True, text=True, timeout=600)


def judge(arguments):
    programs, program, seed = arguments
    effects, kind, scene, volts = scene_of(seed)
    result = {"seed": seed, "effects": effects, "drive": kind, "verdicts": {}}
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "scene.toml"), "w", encoding="utf-8") as file:
            file.write(toml_of(scene))
        if volts:
            with open(os.path.join(folder, "drive.csv"), "w", encoding="utf-8") as file:
                file.write("voltage_v\n" + "\n".join(repr(volt) for volt in volts) + "\n")
        answers = {accuracy: run_program(programs, folder, ["--accuracy", repr(accuracy)]) for accuracy in ACCURACIES}
        timed = run_program(programs, folder, ["--explain"])
    runs = {accuracy: json.loads(done.stdout)["run"] for accuracy, done in answers.items() if done.returncode == 0}
    for accuracy, done in answers.items():
        if done.returncode not in (0, 3):
            result["verdicts"][accuracy] = f"status {done.returncode}: {done.stderr.strip()[:150]}"
    if runs:
        begin, end = next(iter(runs.values()))["window_s"]
        truth, moved = reference.run_reference(
            program, [reference_text(scene, volts, end - begin, factor) for factor in (1.0, 1 + 2e-15)], seconds=600)
        own = deviation(moved, truth)[0]
        result["own"] = own
    for accuracy in ACCURACIES:
        if accuracy in result["verdicts"]:
            continue
        if accuracy not in runs:
            result["verdicts"][accuracy] = "refused"
        elif truth["stalled"] or own > accuracy / 10:
            result["verdicts"][accuracy] = "unpredictable"
        else:
            off, which = deviation(runs[accuracy], truth)
            holds = off <= accuracy + OWN_ERROR and off <= runs[accuracy]["error_estimate"] + OWN_ERROR
            result["verdicts"][accuracy] = "holds" if holds else f"VIOLATED: {which} {off:.2g}"
    if timed.returncode == 0:
        result["ms"] = [1e3 * row["answer_s"] for row in json.loads(timed.stdout)["accuracies"] if row["error_estimate"] is not None]
    return result


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("programs")
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--verbose", action="store_true")
    options = parser.parse_args()
    counts = collections.defaultdict(collections.Counter)
    slower, timed = 0, 0
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(options.workers) as pool:
        program = reference.build_reference(folder)
        seeds = range(options.first, options.first + options.count)
        for result in pool.map(judge, [(options.programs, program, seed) for seed in seeds]):
            verdicts = [verdict.split(":")[0] for verdict in result["verdicts"].values()]
            for verdict in verdicts:
                counts["+".join(result["effects"]) or "linear"][verdict] += 1
            ms = result.get("ms", [])
            rises = any(tight * 1.25 + 0.2 < loose for loose, tight in zip(ms, ms[1:]))
            slower += rises
            timed += bool(ms)
            if options.verbose or rises or set(verdicts) - {"holds", "refused", "unpredictable"}:
                print(json.dumps(result), flush=True)
    faults = 0
    for name, verdicts in counts.items():
        print(f"{name}: " + ", ".join(f"{count} {verdict}" for verdict, count in sorted(verdicts.items())))
        faults += sum(count for verdict, count in verdicts.items() if verdict not in ("holds", "refused", "unpredictable"))
    print(f"a looser accuracy took longer in {slower} of {timed} scenes")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
