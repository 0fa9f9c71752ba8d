"""The document, the page and each table or file that a verb writes says which program made it, with which command,
when, and from which inputs (bytes and SHA-256); numbers say what kind of data they are of."""
import hashlib
import json
import os
import re
import shlex
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import check, run

# command; its inputs; the source of its data (None: it shows no data); files with the provenance in their text
COMMANDS = [
    ("simulate fixtures/lra_adapter.toml --duration 0.6s -o simulated.bin --waveforms w.csv --report simulate.html",
     ["fixtures/lra_adapter.toml"], ["simulated"], ["simulated.bin", "w.csv", "simulate.html"]),
    ("acquire --sensor scene:fixtures/lra_adapter.toml --speed max --duration 0.5s -o acquired.bin --report acquire.html",
     ["fixtures/lra_adapter.toml"], ["simulated"], ["acquire.html"]),
    ("acquire --sensor replay --port cut.bin --speed max -o again.bin", ["cut.bin"], ["emulated"], []),
    ("acquire --list-sensors", [], None, []),
    ("trial info simulated.bin --report info.html", ["simulated.bin"], ["simulated"], ["info.html"]),
    ("analyze simulated.bin --spectrum spectrum.csv --report analyze.html", ["simulated.bin"], ["simulated"],
     ["spectrum.csv", "analyze.html"]),
    ("analyze fixtures/recorded_trial.bin", ["fixtures/recorded_trial.bin"], ["emulated"], []),
    ("analyze cut.bin", ["cut.bin"], ["emulated", "interrupted"], []),
    ("analyze plain.csv", ["plain.csv"], ["imported"], []),
    ("fit-lra fixtures/impulse.csv --save actuator.toml --report fit.html", ["fixtures/impulse.csv"], ["imported"],
     ["actuator.toml", "fit.html"]),
    ("plan-drop-test --actuator actuator.toml --report plan.html", ["actuator.toml"], None, ["plan.html"]),
    ("tune fixtures/lra_adapter.toml --springs 8200 --report tune.html", ["fixtures/lra_adapter.toml"], ["simulated"],
     ["tune.html"]),
    ("sweep fixtures/lra_adapter.toml --vary drive.frequency_hz=200,225 -o sweep.csv", ["fixtures/lra_adapter.toml"],
     ["simulated"], ["sweep.csv"]),
    ("study trials --pattern s{subject}_{condition} --table table.csv --wide wide.csv --methods methods.md --report study.html",
     ["trials/s1_a.bin", "trials/s1_b.csv", "trials/s2_a.bin", "trials/s2_b.csv"],
     ["emulated", "simulated", "imported", "interrupted"], ["table.csv", "wide.csv", "methods.md", "study.html"]),
    ("study matching fixtures/matching.csv --report matching.html", ["fixtures/matching.csv"], ["imported"],
     ["matching.html"]),
    ("session status day", ["day/session.toml"], None, []),
    ("compare fixtures/recorded_trial.bin fixtures/lra_adapter.toml --input drive.amplitude_v=5+-1 --report compare.html",
     ["fixtures/lra_adapter.toml", "fixtures/recorded_trial.bin"], ["emulated", "simulated"], ["compare.html"]),
    ("study compare trials fixtures/lra_adapter.toml --input drive.amplitude_v=5+-1 --input drive.frequency_hz=225+-1 "
     "--pattern s{subject}_{condition} --table cells.csv --report cells.html",
     ["fixtures/lra_adapter.toml", "trials/s1_a.bin", "trials/s1_b.csv", "trials/s2_a.bin", "trials/s2_b.csv"],
     ["emulated", "simulated", "imported", "interrupted"], ["cells.csv", "cells.html"]),
    ("reproduce --report reproduce.html", [], ["simulated"], ["reproduce.html"]),
]
VERSION = re.compile(r"haptometer \d+\.\d+\.\d+")


def sources(value):
    """Every `data_source` within a document."""
    if isinstance(value, dict):
        yield from value.get("data_source") or []
        for part in value.values():
            yield from sources(part)
    elif isinstance(value, list):
        for part in value:
            yield from sources(part)


def check_document(command, inputs, expected):
    document = json.loads(run(*shlex.split(command), "--json").stdout)
    provenance = document["provenance"]
    check(re.fullmatch(r"\d+\.\d+\.\d+", provenance["version"]), provenance)
    check(provenance["command"] == f"haptometer {command} --json".replace("{", "'{").replace("} ", "}' ")
          or shlex.split(provenance["command"])[1:-1] == shlex.split(command), provenance["command"])
    check(re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z", provenance["utc"]), provenance["utc"])
    named = [one["path"] for one in provenance["inputs"]]
    check(sorted(named) == sorted(inputs), f"{command}: inputs {named}")
    for one in provenance["inputs"]:
        with open(one["path"], "rb") as file:
            content = file.read()
        check(one["bytes"] == len(content), f"{command}: {one}")
        check(one["sha256"] == hashlib.sha256(content).hexdigest(), f"{command}: {one}")
    check(isinstance(document["findings"], list), command)
    found = set(sources(document))
    check(found == set(expected or []), f"{command}: data are of {sorted(found)}")
    return [one["sha256"] for one in provenance["inputs"]]


def check_file(path, command, digests, expected):
    """Version, command and inputs in a file's text; the source of the data on a page and in methods."""
    with open(path, "rb") as file:
        text = file.read().decode("utf-8", "replace")
    check(VERSION.search(text), f"{path} names no version")
    check(command.split()[0] in text and "--json" in text, f"{path} names no command")
    for digest in digests:
        check(digest in text, f"{path} has no SHA-256 {digest}")
    if path.endswith((".html", ".md")):
        for source in expected or []:
            check(source in text, f"{path} does not say that data are {source}")


def make_inputs(fixtures):
    os.symlink(fixtures, "fixtures")
    with open("fixtures/recorded_trial.bin", "rb") as file:
        recorded = file.read()
    with open("cut.bin", "wb") as file:
        file.write(recorded[:100000])
    run("trial", "export", "fixtures/recorded_trial.bin", "-o", "whole.csv")
    with open("whole.csv", encoding="utf-8") as file:
        rows = [line for line in file if not line.startswith("#")]
    with open("plain.csv", "w", encoding="utf-8") as file:
        file.writelines(rows)
    run("session", "new", "day", "--subjects", "2", "--conditions", "a,b", "--duration", "1s", "--", "--port", "/dev/none")
    os.mkdir("trials")
    with open("trials/s1_a.bin", "wb") as file:
        file.write(recorded[:100000])
    run("simulate", "fixtures/lra_adapter.toml", "--duration", "1s", "-o", "trials/s2_a.bin")
    for name in ("s1_b", "s2_b"):
        with open(f"trials/{name}.csv", "w", encoding="utf-8") as file:
            file.writelines(rows)


def main():
    fixtures = os.path.abspath("fixtures")
    os.environ["HAPTOMETER_PROGRAMS"] = os.path.abspath(os.environ.get("HAPTOMETER_PROGRAMS", "build/release/bin"))
    with tempfile.TemporaryDirectory() as directory:
        os.chdir(directory)
        make_inputs(fixtures)
        for command, inputs, expected, files in COMMANDS:
            digests = check_document(command, inputs, expected)
            for path in files:
                check_file(path, command, digests, expected)
        os.chdir("/")
    print(f"{len(COMMANDS)} commands, {sum(len(files) for *_, files in COMMANDS)} files")


if __name__ == "__main__":
    main()
