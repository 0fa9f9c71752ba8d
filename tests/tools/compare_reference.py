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


def reference(measured=MEASURED, values=VALUES):
    keys = list(values)
    x, u = np.array([values[key] for key in keys]).T
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
    measured, of_measurement = np.array(list(measured.values())).T
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


def recorded(path, values, seed):
    """A DAQ's table of displacement, voltage and current of an actuator on the skin."""
    rms, tone, current, _, phase = numbers([value for value, _ in values.values()])
    draw, t = np.random.default_rng(seed), np.arange(12000) / 1e4
    angle = 2 * np.pi * tone * t
    columns = (t, 2**.5 * rms * np.sin(angle + 1) + draw.normal(0, 1e-7, t.size),
               values["drive.amplitude_v"][0] * np.sin(angle) + draw.normal(0, 1e-3, t.size),
               2**.5 * current * np.sin(angle + phase) + draw.normal(0, 1e-4, t.size))
    np.savetxt(path, np.array(columns).T, "%.12g", ",", header="time_s,displacement_m,voltage_v,current_a", comments="")


def mean(numbers_of):
    """Of pairs (value, u): the mean, and the root of s^2 / n + mean of u^2."""
    y, u = np.array(numbers_of).T
    return y.mean(), np.sqrt(y.var(ddof=1) / len(y) + (u**2).mean())


PLACES = {"skin_rms_m": ("band_rms_m", "band_rms_standard_uncertainty_m"),
          "tone_frequency_hz": ("tone_frequency_hz", "tone_frequency_standard_uncertainty_hz"),
          "current_rms_a": "current_rms_a", "power_w": "real_power_w", "phase_rad": "phase_rad"}


def measured_in(trial):
    """(value, u) of each quantity of a trial of `analyze --json`."""
    electrical = trial["electrical"]
    return {key: tuple(electrical[place][name] for name in ("value", "standard_uncertainty")) if isinstance(place, str)
            else tuple(trial[name] for name in place) for key, place in PLACES.items()}


def check_study():
    """Three subjects of two conditions, of which one has a scene and a key of its own, two repeats: each number again,
    from what `analyze` says of the trials on."""
    os.mkdir("study")
    drives = {"strong": (5, 0.04), "weak": (3, 0.03)}
    skins, tones = (800, 900, 1050), {("strong", 1): 226.1}
    for condition, drive in drives.items():
        pathlib.Path(f"{condition}.toml").write_text(SCENE.replace("amplitude_v = 5", f"amplitude_v = {drive[0]}"))
        for subject, skin in enumerate(skins):
            truth = VALUES | {"drive.amplitude_v": drive, "skin.stiffness_n_per_m": (skin, 0),
                              "drive.frequency_hz": (tones.get((condition, subject), 225.05), 0)}
            for repeat in (1, 2):
                recorded(f"study/{subject}_{condition}_{repeat}.csv", truth, seed=[subject, drive[0], repeat])
    words = ["study", "compare", "study", "strong.toml", "--condition", "weak=weak.toml", "--pattern",
             "{subject}_{condition}_{repeat}", *WORDS[:4], *WORDS[6:], "--input", "strong:drive.amplitude_v=5V+-40mV",
             "--input", "weak:drive.amplitude_v=3V+-30mV"]
    answer = json.loads(run(*words, "--json", "--table", "cells.csv", "--report", "page.html").stdout)
    cells = {(one["condition"], int(one["subject"]), one["key"]): one for one in answer["cells"]}
    worst = 0
    for condition, drive in zip(answer["conditions"], drives):
        check(condition["name"] == drive and condition["scene"] == f"{drive}.toml", condition)
        values = VALUES | {"drive.amplitude_v": drives[drive]}
        of_subjects, deviations = [], []
        for subject in range(3):
            names = [f"study/{subject}_{drive}_{repeat}.csv" for repeat in (1, 2)]
            trials = [measured_in(one) for one in json.loads(run("analyze", *names, "--json").stdout)["trials"]]
            of_subjects.append({key: mean([one[key] for one in trials]) for key in PLACES})
            _, d, _, zeta, *_ = reference(of_subjects[-1], values)
            deviations.append(d)
            for k, key in enumerate(PLACES):
                one = cells[drive, subject, key]
                near(f"u {key}", one["measured_uncertainty"], of_subjects[-1][key][1], 1e-9)
                worst = max(worst, near(f"zeta {drive} {subject} {key}", one["zeta_score"], zeta[k], 2e-3))
                check(one["trials"] == 2 and one["normalized_error"] == one["zeta_score"] / 2, one)
        over = {key: mean([one[key] for one in of_subjects]) for key in PLACES}
        keys, d, _, zeta, pull, _, _, chi_squared = reference(over, values)
        near("chi_squared", condition["chi_squared"], chi_squared, 5e-3)
        # Student's quantile for 95 % and 2 degrees of freedom
        half = 0.95 / np.sqrt(2 * 0.975 * 0.025) * np.std(deviations, axis=0, ddof=1) / 3**.5
        for k, one in enumerate(condition["quantities"]):
            worst = max(worst, near(f"zeta {drive} {one['key']}", one["zeta_score"], zeta[k], 2e-3))
            near(f"deviation {one['key']}", one["deviation"], d[k], 1e-6)
            low, high = one["deviation_interval_95"]
            near(f"interval {one['key']}", high - low, 2 * half[k], 1e-6)
            near(f"middle {one['key']}", (high + low) / 2, np.mean(deviations, axis=0)[k], 1e-6)
            differing = sum(abs(cells[drive, subject, one["key"]]["normalized_error"]) > 1 for subject in range(3))
            check(one["subjects_differing"] == differing and one["subjects"] == 3, one)
        for one in condition["inputs"]:
            check(one["explaining_value"] is None, one)
            worst = max(worst, near(f"pull {one['key']}", one["pull"], pull[keys.index(one["key"])], 5e-3))
    tone = cells["strong", 1, "tone_frequency_hz"]
    check(tone["explained_by"] == "drive.frequency_hz" and tone["normalized_error"] > 1, tone)
    check(answer["conditions"][0]["quantities"][1]["subjects_differing"] == 1 and answer["agrees"], answer["conditions"])
    table = [line for line in pathlib.Path("cells.csv").read_text().splitlines() if not line.startswith("#")]
    check(len(table) == 31 and table[0].startswith("subject,condition,trials,key,measured,"), table[0])
    command = re.search("# command: haptometer (.*)", pathlib.Path("cells.csv").read_text())[1]
    check(command.startswith("study compare study strong.toml"), command)
    check(pathlib.Path("page.html").read_text().count("<svg") == 1, "the page has a figure")
    print(f"study of 2 conditions, 3 subjects: largest deviation from NumPy {worst:.1e}")
    check_study_refusals(words)


def check_study_refusals(words):
    for more, said in ((["--condition", "weak=strong.toml"], "weak is given twice"),
                       (["--condition", "wek=strong.toml"], "wek: is no condition of the study; its conditions are strong"),
                       (["--input", "wek:drive.amplitude_v=3+-1"], "wek: is no condition of the study"),
                       (["--input", "weak:skin.damping_n_s_per_m=0.75+-0.1"], "skin.damping_n_s_per_m is given twice"),
                       (["--uncertainty", "rise_s=1%"], "--uncertainty rise_s: is not measured"),
                       (["weak.toml"], "is a second scene")):
        status = 3 if "not measured" in said else 2
        done = run(*words, *more, status=status)
        # a slow build says that it works
        lines = [line for line in done.stderr.splitlines() if "; Ctrl-C ends it" not in line]
        check(len(lines) == 1 and said in lines[0], done.stderr)
    alone = run("study", "compare", "study", *words[6:8], status=2)
    check("is a condition without a scene; give --condition strong=SCENE.toml" in alone.stderr, alone.stderr)
    # a session's scene
    pathlib.Path("played.toml").write_text(SCENE + '[sensor]\nkind = "stream"\n')
    run("session", "new", "day", "--subjects", "1", "--conditions", "weak", "--repeats", "1", "--duration", "1s", "--",
        "--sensor", "scene:played.toml", "--speed", "max")
    run("session", "next", "day")
    day = json.loads(run("study", "compare", "day", "--json").stdout)
    check([one["scene"] for one in day["conditions"]] == [os.path.abspath("played.toml")], day["conditions"])


with tempfile.TemporaryDirectory() as folder:
    os.environ["HAPTOMETER_PROGRAMS"] = os.path.abspath(os.environ.get("HAPTOMETER_PROGRAMS", "build/release/bin"))
    os.chdir(folder)
    check_equations()
    check_trials()
    check_study()
    os.chdir("/")
