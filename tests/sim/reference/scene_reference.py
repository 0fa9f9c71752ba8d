#!/usr/bin/env python3
"""Random scenes with effects, as scene.toml for the program and as lines for scene_reference.

The pairs of effects are gone through in turn (rigid and compliant stops apart), all numbers are drawn
from a seed. Used by tests/long, and as a command:

    scene_reference.py --write             makes scene_references.json anew: 101 scenes and their numbers
    scene_reference.py --check             compares scene_reference with known numbers and with every
                                           twentieth of those committed, and what `simulate` answers to
                                           every scene with its reference: the deviation has to lie
                                           below the error that it states
"""
import argparse
import concurrent.futures
import itertools
import json
import math
import os
import random
import subprocess
import sys
import tempfile

EFFECTS = ["gravity", "rigid_stops", "compliant_stops", "stiffening", "contact_loss", "tremor", "coil_heating"]
PAIRS = [pair for pair in itertools.combinations(EFFECTS, 2) if pair != ("rigid_stops", "compliant_stops")]


def log_uniform(draw, low, high):
    return math.exp(draw.uniform(math.log(low), math.log(high)))


def number(value):
    """A double that both programs read alike."""
    return float(f"{value:.6g}")


def random_scene(seed, effects=None, tolerance=None, periods=None):
    """A scene as a dictionary of tables, from a seed alone."""
    draw = random.Random(seed)
    pair = PAIRS[seed % len(PAIRS)] if effects is None else effects
    actuator = {
        "moving_mass_kg": number(log_uniform(draw, 0.7e-3, 3e-3)),
        "case_mass_kg": number(log_uniform(draw, 0.3e-3, 2e-3)),
        "damping_n_s_per_m": number(log_uniform(draw, 0.01, 0.2)),
        "force_constant_n_per_a": number(draw.uniform(0.4, 1.5)),
        "resistance_ohm": number(draw.uniform(8, 40)),
        "inductance_h": number(log_uniform(draw, 2e-5, 1e-3)),
    }
    resonance_hz = draw.uniform(90, 260)
    actuator["stiffness_n_per_m"] = number((2 * math.pi * resonance_hz) ** 2 * actuator["moving_mass_kg"])
    scene = {"actuator": actuator}
    if draw.random() < 0.6:
        scene["adapter"] = {
            "motor_side_mass_kg": number(log_uniform(draw, 0.1e-3, 0.5e-3)),
            "skin_side_mass_kg": number(log_uniform(draw, 1e-3, 6e-3)),
            "stiffness_n_per_m": number(log_uniform(draw, 3000, 2e4)),
            "damping_n_s_per_m": number(log_uniform(draw, 0.01, 0.3)),
        }
    scene["skin"] = {
        "stiffness_n_per_m": number(draw.uniform(600, 2000)),
        "damping_n_s_per_m": number(draw.uniform(0.75, 2.4)),
    }
    frequency = number(draw.choice([draw.uniform(40, 400), resonance_hz * draw.uniform(0.9, 1.1)]))
    scene["drive"] = {"kind": "sine", "amplitude_v": number(log_uniform(draw, 0.5, 6)), "frequency_hz": frequency}
    on = {"inductance": draw.random() < 0.8}
    for effect in pair:
        on["travel_stops" if effect.endswith("stops") else effect] = True
    if "gravity" in pair:
        scene["gravity"] = {"acceleration_m_per_s2": draw.choice([9.80665, -9.80665, number(draw.uniform(-10, 10))])}
    if "rigid_stops" in pair:
        scene["travel_stops"] = {
            "gap_m": number(log_uniform(draw, 2e-5, 5e-4)),
            "restitution": draw.choice([0, 0, number(draw.uniform(0, 0.9)), number(draw.uniform(0.3, 0.8))]),
        }
    if "compliant_stops" in pair:
        stops = {
            "gap_m": number(log_uniform(draw, 2e-5, 5e-4)),
            "stiffness_n_per_m": number(log_uniform(draw, 1e4, 1e8)),
        }
        stops["damping_n_s_per_m"] = number(
            draw.choice([0, 1, 1]) * draw.uniform(0.05, 1) * 2 * math.sqrt(stops["stiffness_n_per_m"] * 5e-4))
        scene["travel_stops"] = stops
    if "stiffening" in pair:
        travel = log_uniform(draw, 1e-4, 1e-3)  # where the cubic doubles the stiffness
        scene["stiffening"] = {"cubic_n_per_m3": number(actuator["stiffness_n_per_m"] / travel**2)}
    if "contact_loss" in pair:
        # held to the skin where gravity pulls away from it
        masses = sum(value for part in ("actuator", "adapter") for key, value in scene.get(part, {}).items()
                     if key.endswith("mass_kg"))
        weight = masses * abs(scene.get("gravity", {}).get("acceleration_m_per_s2", 0))
        scene["skin"]["preload_n"] = number(max(log_uniform(draw, 0.01, 0.5), 1.5 * weight))
    if "tremor" in pair:
        scene["tremor"] = {"amplitude_m": number(log_uniform(draw, 1e-5, 3e-4)), "frequency_hz": number(draw.uniform(4, 12))}
    if "coil_heating" in pair:
        scene["coil_heating"] = {
            "heat_capacity_j_per_k": number(log_uniform(draw, 3e-3, 0.3)),
            "thermal_resistance_k_per_w": number(draw.uniform(20, 100)),
        }
    scene["effects"] = on
    count = draw.uniform(12, 40) if periods is None else periods
    scene["run"] = {
        "duration_s": number(count / frequency),
        "tolerance": float(f"{10 ** -draw.uniform(3, 10):.1e}") if tolerance is None else tolerance,
    }
    return scene


def toml_of(scene):
    """The scene as the text of scene.toml."""
    lines = []
    for table, values in scene.items():
        lines.append(f"[{table}]")
        for key, value in values.items():
            lines.append(f"{key} = {json.dumps(value)}")
    return "\n".join(lines) + "\n"


def reference_lines(scene, window_s=None, strobe=False, amplitude_factor=1.0, tolerance=None):
    """The scene as scene_reference reads it; window_s: length of the window before the end."""
    a, skin, drive, on = scene["actuator"], scene["skin"], scene["drive"], scene["effects"]
    out = {
        "mv": a["moving_mass_kg"], "mc": a["case_mass_kg"], "kv": a["stiffness_n_per_m"],
        "bv": a["damping_n_s_per_m"], "km": a["force_constant_n_per_a"], "r": a["resistance_ohm"],
        "l": a["inductance_h"] if on.get("inductance", True) else 0.0,
        "ks": skin["stiffness_n_per_m"], "bs": skin["damping_n_s_per_m"], "preload": skin.get("preload_n", 0.0),
    }
    if "adapter" in scene:
        d = scene["adapter"]
        out |= {"adapter": 1, "ma1": d["motor_side_mass_kg"], "ma2": d["skin_side_mass_kg"],
                "ka": d["stiffness_n_per_m"], "ba": d["damping_n_s_per_m"]}
    if on.get("contact_loss"):
        out["unilateral"] = 1
    if on.get("travel_stops"):
        s = scene["travel_stops"]
        out |= {"stops": 1, "gap_up": s["gap_m"], "gap_down": s["gap_m"], "restitution": s.get("restitution", 0.0),
                "stop_k": s.get("stiffness_n_per_m", 0.0), "stop_c": s.get("damping_n_s_per_m", 0.0)}
    if on.get("stiffening"):
        out["k3"] = scene["stiffening"]["cubic_n_per_m3"]
    if on.get("gravity"):
        out["gravity"] = scene.get("gravity", {}).get("acceleration_m_per_s2", 9.80665)
    if on.get("coil_heating"):
        h = scene["coil_heating"]
        out |= {"heat_c": h["heat_capacity_j_per_k"], "heat_rth": h["thermal_resistance_k_per_w"],
                "alpha": h.get("resistance_per_k", 3.93e-3)}
    duration = scene["run"]["duration_s"]
    out["duration"] = duration
    out["window"] = min(duration, 10 / drive["frequency_hz"]) if window_s is None else window_s
    if strobe:
        out["strobe"] = 1 / drive["frequency_hz"]
    if tolerance is not None:
        out["tolerance"] = tolerance
    lines = [f"{key} {value!r}" for key, value in out.items()]
    amplitude = drive["amplitude_v"] * amplitude_factor
    lines.append(f"drive {amplitude!r} {drive['frequency_hz']!r}")
    if on.get("tremor"):
        lines.append(f"tremor {scene['tremor']['amplitude_m']!r} {scene['tremor']['frequency_hz']!r}")
    return "\n".join(lines) + "\n\n"


def build_reference(folder):
    """The path of scene_reference, compiled into a folder: its own flags, none of the product's."""
    source = os.path.join(os.path.dirname(os.path.abspath(__file__)), "scene_reference.cc")
    program = os.path.join(folder, "scene_reference")
    subprocess.run(["g++", "-std=c++20", "-O2", "-o", program, source], check=True)
    return program


def run_reference(program, texts, seconds=300):
    """The answers of scene_reference to several scenes."""
    done = subprocess.run([program], input="".join(texts), capture_output=True, text=True, timeout=seconds, check=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


REFERENCES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "scene_references.json")
COUNT = 100
# of tests/long/nonlinear_scenes.py: contact that magnifies deviations, and the least that the solver takes
FURTHER = [418]
QUANTITIES = ["skin_rms_m", "case_rms_m", "current_rms_a", "power_w", "mover_peak_m"]
# The reference's own steps of 1e-20 leave 4e-15 in scenes of 12 periods (against steps of 1e-17).
OWN_ERROR = 1e-13


def deviation(measured, true):
    """The largest relative deviation of the numbers of a run, and of which."""
    return max((abs(measured[key] - true[key]) / max(abs(true[key]), 1e-300), key) for key in QUANTITIES)


def simulated(scene, seconds=300):
    """What `simulate` does with a scene: exit status, its document or None, its words on stderr."""
    program = os.path.join(os.environ.get("HAPTOMETER_PROGRAMS", "build/release/bin"), "haptometer")
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scene.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(toml_of(scene))
        done = subprocess.run([program, "simulate", path, "--json"], capture_output=True, text=True, timeout=seconds)
    return done.returncode, json.loads(done.stdout) if done.returncode == 0 else None, done.stderr


def write(program):
    """Scenes of 12 periods that perturbations of 1e-15 leave as they are to 1e-11."""
    kept = []
    seed = 0
    while len(kept) < COUNT:
        scene = random_scene(7_000_000 + seed, effects=PAIRS[seed % len(PAIRS)], periods=12)
        seed += 1
        true, moved = run_reference(program, [reference_lines(scene), reference_lines(scene, amplitude_factor=1 + 2e-15)])
        if not true["stalled"] and deviation(moved, true)[0] < 1e-11:
            kept.append({"scene": scene, "numbers": true})
    for seed in FURTHER:
        scene = random_scene(seed)
        kept.append({"scene": scene, "numbers": run_reference(program, [reference_lines(scene)])[0]})
    with open(REFERENCES, "w", encoding="utf-8") as file:
        file.write("[\n" + ",\n".join(json.dumps(one) for one in kept) + "\n]\n")


def known_numbers(program):
    """scene_reference beside numbers that do not come from it."""
    thesis = {"moving_mass_kg": 1.4e-3, "case_mass_kg": 0.6e-3, "stiffness_n_per_m": 2800.0, "damping_n_s_per_m": 0.0322,
              "force_constant_n_per_a": 1.0, "resistance_ohm": 27.0, "inductance_h": 130e-6}
    scene = {"actuator": thesis,
             "adapter": {"motor_side_mass_kg": 0.25e-3, "skin_side_mass_kg": 4.35e-3, "stiffness_n_per_m": 8200.0,
                         "damping_n_s_per_m": 0.01},
             "skin": {"stiffness_n_per_m": 600.0, "damping_n_s_per_m": 0.75},
             "drive": {"kind": "sine", "amplitude_v": 5.0, "frequency_hz": 225.0}, "effects": {}, "run": {"duration_s": 0.1}}
    linear = run_reference(program, [reference_lines(scene)])[0]["skin_rms_m"]
    yield "linear scene against linear_reference.py (mpmath)", linear, 1.9117910472254904510e-4, 1e-14
    # rest on a rigid stop is the limit of stiff pads that let nothing bounce (4e-7 at 1e10 N/m)
    resting = {"actuator": thesis, "skin": scene["skin"], "effects": {"travel_stops": True, "stiffening": True},
               "drive": {"kind": "sine", "amplitude_v": 5.0, "frequency_hz": 60.0}, "run": {"duration_s": 0.05},
               "stiffening": {"cubic_n_per_m3": 4e12}, "travel_stops": {"gap_m": 3e-5, "restitution": 0.0}}
    pads = resting | {"travel_stops": {"gap_m": 3e-5, "stiffness_n_per_m": 1e10, "damping_n_s_per_m": 1e5}}
    rigid, stiff = (one["skin_rms_m"] for one in run_reference(program, [reference_lines(resting), reference_lines(pads)]))
    yield "rest on a rigid stop against pads of 1e10 N/m", stiff, rigid, 1e-6


def check(program):
    """The number of failures."""
    faults = 0
    for name, value, known, tolerance in known_numbers(program):
        if abs(value - known) > tolerance * abs(known):
            print(f"{name}: {value!r}, known {known!r}")
            faults += 1
    with open(REFERENCES, encoding="utf-8") as file:
        references = json.load(file)
    for one in references[::20]:
        again = run_reference(program, [reference_lines(one["scene"])])[0]
        if deviation(again, one["numbers"])[0] > OWN_ERROR:
            print("a committed reference is not what scene_reference gives:", json.dumps(one["scene"]))
            faults += 1
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        answers = list(pool.map(lambda one: simulated(one["scene"]), references))
    answered = 0
    for one, (status, document, words) in zip(references, answers):
        if status == 3:
            print("refused:", words.strip()[:150])
            continue
        if status != 0:
            print(f"status {status}: {words.strip()[:200]}")
            faults += 1
            continue
        answered += 1
        off, which = deviation(document["run"], one["numbers"])
        stated = document["run"]["error_estimate"]
        if not off <= stated + OWN_ERROR:
            print(f"{which} is {off:.2g} off, stated {stated:.2g}: {json.dumps(one['scene'])}")
            faults += 1
    print(f"{answered} of {len(references)} scenes answered, {faults} faults")
    # a motion that has lost its digits may be refused; these keep 11 of them, but for the further one
    return faults + (answered < 0.95 * len(references) - len(FURTHER))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        program = build_reference(folder)
        if options.write:
            write(program)
        return 1 if options.check and check(program) else 0


if __name__ == "__main__":
    sys.exit(main())
