"""`haptometer compare` against the equations of tools/compare/compare.h, written here a second time: the motion by
NumPy from the equations of J. Lindsay, "A Mechanical Amplifier for Haptic Feedback", 2013 (2.1-2.4, no states, one
complex equation a body), S C S^T with C as a whole, V by its inverse. And the way of a user: a scene is simulated to
trials, which are analysed and compared."""
import json
import os
import pathlib
import re
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import check, run, skip

try:
    import numpy as np
except ImportError:
    skip("NumPy is missing")

VALUES = {"actuator.moving_mass_kg": (1.4e-3, 0.02e-3), "actuator.case_mass_kg": (0.6e-3, 0), "actuator.stiffness_n_per_m":
          (2800, 60), "actuator.damping_n_s_per_m": (0.0322, 0.002), "actuator.force_constant_n_per_a": (1.0, 0.03),
          "actuator.resistance_ohm": (27, 0), "actuator.inductance_h": (130e-6, 0), "skin.stiffness_n_per_m": (900, 600 / 12**.5),
          "skin.damping_n_s_per_m": (0.75, 0.05), "drive.amplitude_v": (5, 0.04), "drive.frequency_hz": (225, 0.2)}
CORRELATED = ("actuator.moving_mass_kg", "actuator.stiffness_n_per_m", 0.97)
WORDS = ["--input", "skin.stiffness_n_per_m=600:1200", "--input", "skin.damping_n_s_per_m=0.75(5)", "--input",
         "drive.amplitude_v=5V+-40mV", "--input", "drive.frequency_hz=225Hz+-0.2Hz"]
SCENE = """
[actuator]
moving_mass_kg = "1.40(2)g"
case_mass_kg = 0.6e-3
stiffness_n_per_m = "2800(60)"
damping_n_s_per_m = "0.0322(20)"
force_constant_n_per_a = "1.00(3)"
resistance_ohm = 27
inductance_h = 130e-6
[actuator.correlation]
Mv_Kv = 0.97
[skin]
stiffness_n_per_m = 600
damping_n_s_per_m = 0.75
[drive]
kind = "sine"
amplitude_v = 5
frequency_hz = 225
"""
# what is measured, and its standard uncertainty
MEASURED = {"skin_rms_m": (45e-6, 0.4e-6), "tone_frequency_hz": (225.3, 0.05), "current_rms_a": (0.1292, 0.0006),
            "power_w": (0.4575, 0.003), "phase_rad": (-0.031, 0.002)}


def numbers(x):
    """Skin RMS, tone, current RMS, power and phase of an actuator on the skin, by two complex equations."""
    mv, mc, kv, bv, km, r, l, ks, bs, v, f = x
    s = 2j * np.pi * f
    z = r + s * l
    spring = kv + bv * s + km**2 * s / z  # back EMF: i = (V + Km (vv - va)) / z
    matrix = np.array([[mv * s**2 + spring, -spring], [-spring, mc * s**2 + spring + ks + bs * s]])
    mover, case = np.linalg.solve(matrix, np.array([-km * v / z, km * v / z]))
    current = (v + km * s * (mover - case)) / z
    return np.array([abs(case) / 2**.5, f, abs(current) / 2**.5, (current * v).real / 2, np.angle(current)])


def reference():
    keys = list(VALUES)
    x, u = np.array([VALUES[key] for key in keys]).T
    varied = [k for k in range(len(keys)) if u[k] > 0]
    c = np.diag(u**2)
    i, j = keys.index(CORRELATED[0]), keys.index(CORRELATED[1])
    c[i, j] = c[j, i] = CORRELATED[2] * u[i] * u[j]
    c = c[np.ix_(varied, varied)]
    # derivatives by small steps: the program's are secants over a standard uncertainty
    s = np.empty((5, len(varied)))
    for column, k in enumerate(varied):
        step = np.zeros_like(x)
        step[k] = x[k] * 1e-5
        s[:, column] = (numbers(x + step) - numbers(x - step)) / (2 * step[k])
    measured, of_measurement = np.array(list(MEASURED.values())).T
    d = measured - numbers(x)
    of_scene = s @ c @ s.T
    v = of_scene + np.diag(of_measurement**2)
    weight = np.linalg.inv(v)
    p = c @ s.T @ weight @ s @ c
    shift = c @ s.T @ weight @ d
    spread = np.sqrt(np.diag(p))
    return ([keys[k] for k in varied], d, np.sqrt(np.diag(of_scene)), d / np.sqrt(np.diag(v)), shift / spread,
            x[varied] + shift, p / np.outer(spread, spread), d @ weight @ d)


def near(what, ours, theirs, tolerance):
    error = abs(ours - theirs) / max(abs(theirs), 0.1 if what.startswith(("zeta", "pull")) else 0)
    check(error < tolerance, f"{what}: {ours} and not {theirs}, {error:.2g}")
    return error


def check_equations():
    result = {"trials": [{"file": "a.bin", "answered": True, "reasons": [], "data_source": ["device"],
                          "band": {"lower_hz": 20, "upper_hz": 500}, "electrical": {}}], "findings": []}
    trial = result["trials"][0]
    trial["band_rms_m"], trial["band_rms_standard_uncertainty_m"] = MEASURED["skin_rms_m"]
    trial["tone_frequency_hz"], trial["tone_frequency_standard_uncertainty_hz"] = MEASURED["tone_frequency_hz"]
    for key, name in (("current_rms_a", "current_rms_a"), ("power_w", "real_power_w"), ("phase_rad", "phase_rad")):
        trial["electrical"][name] = dict(zip(("value", "standard_uncertainty"), MEASURED[key]))
    pathlib.Path("result.json").write_text(json.dumps(result))
    pathlib.Path("scene.toml").write_text(SCENE)
    answer = json.loads(run("compare", "result.json", "scene.toml", *WORDS, "--json").stdout)
    # nothing to explain, so that pulls are those of the tangent
    check(all(one["explaining_value"] is None for one in answer["inputs"]), answer["inputs"])
    keys, d, of_scene, zeta, pull, adjusted, correlation, chi_squared = reference()
    check([one["key"] for one in answer["quantities"]] == list(MEASURED), answer["quantities"])
    # 2e-3: secants over a standard uncertainty against derivatives, some 5e-4 here
    worst = 0
    for k, one in enumerate(answer["quantities"]):
        near(f"deviation {one['key']}", one["deviation"], d[k], 1e-9)
        worst = max(worst, near(f"zeta {one['key']}", one["zeta_score"], zeta[k], 2e-3))
        if of_scene[k] > 0:
            worst = max(worst, near(f"u {one['key']}", one["simulated_uncertainty"], of_scene[k], 2e-3))
    inputs = {one["key"]: one for one in answer["inputs"]}
    check(sorted(inputs) == sorted(keys), sorted(inputs))
    for k, key in enumerate(keys):
        worst = max(worst, near(f"pull {key}", inputs[key]["pull"], pull[k], 2e-3))
        near(f"adjusted {key}", inputs[key]["adjusted"], adjusted[k], 1e-3)
    near("chi_squared", answer["chi_squared"], chi_squared, 2e-3)
    order = [abs(one["pull"]) for one in answer["inputs"]]
    leaders = [order[k] for k in range(len(order)) if k == 0 or answer["inputs"][k]["set"] != answer["inputs"][k - 1]["set"]]
    check(leaders == sorted(leaders, reverse=True), "sets are ordered by their largest pull")
    for one in answer["inputs"]:
        first = next(other for other in answer["inputs"] if other["set"] == one["set"])
        check(abs(correlation[keys.index(one["key"]), keys.index(first["key"])]) > 0.94, f"{one['key']}: {first['key']}")
    print(f"largest deviation from NumPy {worst:.1e}; zeta {np.round(zeta, 2)}; pulls {np.round(pull, 2)}")


def check_trials():
    """A scene with a sensor's noise, from rest, whose skin damps more than is stated."""
    sensor = '[sensor]\nkind = "stream"\nnoise_rms_m = 1e-7\nseed = {}\n[run]\nduration_s = 2\nstart = "rest"\n'
    stated = re.sub(r'"([\d.]+)\(\d+\)(g?)"', lambda match: match[1] + ("e-3" if match[2] else ""), SCENE)
    pathlib.Path("stated.toml").write_text(stated + sensor.format(1))
    for seed in (1, 2, 3):
        truth = stated.replace("damping_n_s_per_m = 0.75", "damping_n_s_per_m = 0.85") + sensor.format(seed)
        pathlib.Path("truth.toml").write_text(truth)
        run("simulate", "truth.toml", "-o", f"t{seed}.bin")
    trials = [f"t{seed}.bin" for seed in (1, 2, 3)]
    pathlib.Path("analyzed.json").write_text(run("analyze", *trials, "--json").stdout)
    of_trials = json.loads(run("compare", *trials, "stated.toml", *WORDS, "--json", "--report", "page.html").stdout)
    of_document = json.loads(run("compare", "analyzed.json", "stated.toml", *WORDS, "--json").stdout)
    check(of_trials["quantities"] == of_document["quantities"], "trials and their document are the same")
    check(of_trials["inputs"] == of_document["inputs"], "trials and their document are the same")
    check(of_trials["trials"] == trials and of_trials["agrees"], of_trials["trials"])
    check("<svg" in pathlib.Path("page.html").read_text(), "the page has a figure")
    # the damping alone, stated five standard uncertainties off, is named and found
    done = run("compare", *trials, "stated.toml", "--input", "skin.damping_n_s_per_m=0.75+-0.02", "--json", status=3)
    answer = json.loads(done.stdout)
    damping = answer["inputs"][0]
    check([one["kind"] for one in answer["findings"]][:2] == ["differs", "explained-by"], answer["findings"])
    check(abs(damping["adjusted"] - 0.85) < 3 * damping["adjusted_uncertainty"] + 0.003, damping)
    print(f"{len(of_trials['quantities'])} quantities of 3 trials; a damping of 0.85, stated as 0.75 +- 0.02, is adjusted to "
          f"{damping['adjusted']:.4f} +- {damping['adjusted_uncertainty']:.4f}")


with tempfile.TemporaryDirectory() as folder:
    os.environ["HAPTOMETER_PROGRAMS"] = os.path.abspath(os.environ.get("HAPTOMETER_PROGRAMS", "build/release/bin"))
    os.chdir(folder)
    check_equations()
    check_trials()
    os.chdir("/")
