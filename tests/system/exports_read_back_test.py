"""The answers about a trial and about each of its exports read back are equal: every number and text of `analyze`, `trial
info`, `compare` and `study`, but for the file's name and the kind of finding that a loss is. A format that cannot hold a
trial refuses it.

The trials: a recorded stream (fixtures/), simulated ones of a clocked and of a polled averaging sensor, one with a
damaged block (a gap and its loss), an excluded and labelled one, a piped one of two channels and a calibration.
"""
import json
import math
import os
import shutil
import struct
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import check, run

SENSOR = """
[sensor]
kind = "{kind}"
{more}
"""
STREAM = 'rate_hz = 10000\nresolution_m = 1e-7\nnoise_rms_m = 2e-7\nseed = 7\n'
CALIBRATION = """
averages = 4
sampling_s = 1e-4
[displacement]
scale_m_per_v = 1e-3
relative_standard_uncertainty = 0.005
"""
ENDINGS = ("h5", "mat", "npy", "wav", "csv")
# gaps, readings that are none and rates that are no whole number of hertz
NOT_AS_WAV = {"polled", "damaged"}


def simulated(folder, name, kind, more, duration="4s"):
    scene = os.path.join(folder, name + ".toml")
    with open("fixtures/lra_adapter.toml", encoding="utf-8") as base, open(scene, "w", encoding="utf-8") as file:
        file.write(base.read() + SENSOR.format(kind=kind, more=more))
    path = os.path.join(folder, name + ".bin")
    run("simulate", scene, "--duration", duration, "-o", path)
    return path


def damaged(folder, trial):
    """The trial with one byte changed in the middle of it: a block, and its rows, are lost."""
    path = os.path.join(folder, "damaged.bin")
    content = bytearray(open(trial, "rb").read())
    content[len(content) // 2] ^= 1
    open(path, "wb").write(content)
    return path


def piped(folder):
    """A laser's volts and the drive's, of closed form."""
    samples, calibration = os.path.join(folder, "volts.f64"), os.path.join(folder, "laser.toml")
    with open(samples, "wb") as file:
        for n in range(12000):
            drive = math.sin(2 * math.pi * 200 * n / 8000)
            file.write(struct.pack("<dd", 1.5 + 0.1 * drive + 1e-4 * ((n * 7919) % 13 - 6), drive))
    with open(calibration, "w", encoding="utf-8") as file:
        file.write(CALIBRATION)
    path = os.path.join(folder, "piped.bin")
    run("acquire", "--sensor", "pipe", "--port", samples, "--format", "f64", "--rate", "8kHz",
        "--channels", "displacement:V,voltage:V", "--calibration", calibration, "-o", path)
    return path


def trials(folder):
    """The trials by name."""
    found = {"recorded": shutil.copy("fixtures/recorded_trial.bin", os.path.join(folder, "recorded.bin")),
             "clocked": simulated(folder, "clocked", "stream", STREAM),
             "polled": simulated(folder, "polled", "il-030", 'sampling_s = "0.33ms"\naverages = 4\n')}
    found["damaged"] = damaged(folder, found["clocked"])
    found["excluded"] = shutil.copy(found["clocked"], os.path.join(folder, "excluded.bin"))
    run("trial", "label", found["excluded"], "subject=3", "condition=with \u00e4dapter")
    run("trial", "exclude", found["excluded"], "--reason", "loose cable")
    found["piped"] = piped(folder)
    return found


def without_names(document):
    """The document without what names its input files, and without the kinds of findings: a loss comes back as a remark."""
    document.pop("provenance", None)
    document["findings"] = sorted(finding["text"] for finding in document["findings"])
    for trial in document.get("trials", []):
        if isinstance(trial, dict):
            trial.pop("file", None)
            trial.pop("path", None)
    return document


def analysis(path):
    return without_names(json.loads(run("analyze", path, "--json").stdout))


def facts(path):
    """What `trial info` gives, but for the file itself, its losses and the kind of its findings."""
    document = without_names(json.loads(run("trial", "info", path, "--json").stdout))
    for key in ("file", "file_bytes", "kind", "losses", "rows_lost"):
        document.pop(key)
    return document


def comparison(path, scene):
    document = without_names(json.loads(run("compare", path, scene, "--json").stdout))
    document.pop("trials")
    return document


def differences(ours, theirs, at=""):
    """Where two documents differ."""
    if isinstance(ours, dict) and isinstance(theirs, dict):
        for key in sorted(set(ours) | set(theirs)):
            yield from differences(ours.get(key), theirs.get(key), f"{at}/{key}")
    elif isinstance(ours, list) and isinstance(theirs, list) and len(ours) == len(theirs):
        for number, (a, b) in enumerate(zip(ours, theirs)):
            yield from differences(a, b, f"{at}/{number}")
    elif ours != theirs:
        yield f"{at}: {ours} and {theirs}"


def check_trial(folder, name, trial):
    """Analysis and facts of each export of a trial; how many were compared."""
    expected, known = analysis(trial), facts(trial)
    first = expected["trials"][0]
    check(first["answered"] and first["band_rms_m"] > 0, f"{name} is no test")
    compared = 0
    for ending in ENDINGS:
        export = os.path.join(folder, f"{name}.{ending}")
        if ending == "wav" and name in NOT_AS_WAV:
            run("trial", "export", trial, "-o", export, status=3)
            continue
        run("trial", "export", trial, "-o", export)
        found = list(differences(expected, analysis(export))) + list(differences(known, facts(export)))
        # a CSV holds neither events nor losses, nor whether the trial was finished
        found = [one for one in found if ending != "csv" or not one.startswith(("/events", "/findings", "/closed"))]
        check(not found, f"{name} as {ending}:\n" + "\n".join(found))
        compared += 1
    return compared


def check_comparison(folder):
    scene, trial = os.path.join(folder, "clocked.toml"), os.path.join(folder, "clocked.")
    expected = comparison(trial + "bin", scene)
    for ending in ENDINGS:
        found = list(differences(expected, comparison(trial + ending, scene)))
        check(not found, f"compare {ending}:\n" + "\n".join(found))


def check_study(folder):
    """A study of six trials, from a folder of each kind of file."""
    answers = {}
    for subject in range(3):
        for condition in range(2):
            name = f"{subject}_{condition}"
            more = f'rate_hz = 10000\nresolution_m = 1e-7\nnoise_rms_m = {1 + 3 * condition + subject}e-6\nseed = 3\n'
            trial = simulated(folder, name, "stream", more, "1.2s")
            run("trial", "label", trial, f"subject={subject}", f"condition=c{condition}")
            for ending in ("bin", *ENDINGS):
                os.makedirs(os.path.join(folder, ending), exist_ok=True)
                copy = os.path.join(folder, ending, f"{name}.{ending}")
                shutil.copy(trial, copy) if ending == "bin" else run("trial", "export", trial, "-o", copy)
    for ending in ("bin", *ENDINGS):
        manifest = os.path.join(folder, "study.toml")
        with open(manifest, "w", encoding="utf-8") as file:
            file.write(f'[[trials]]\nfiles = "{ending}/*.{ending}"\n')
        text = run("study", manifest, "--json", "--no-cache").stdout
        answers[ending] = without_names(json.loads(text.replace(f".{ending}", ".bin").replace(f"{ending}/", "bin/")))
    for ending in ENDINGS:
        found = list(differences(answers["bin"], answers[ending]))
        check(not found, f"study of {ending}:\n" + "\n".join(found))


def main():
    with tempfile.TemporaryDirectory() as folder:
        compared = sum(check_trial(folder, name, trial) for name, trial in trials(folder).items())
        check_comparison(folder)
        check_study(folder)
    print(f"{compared} analyses are equal")


if __name__ == "__main__":
    main()
