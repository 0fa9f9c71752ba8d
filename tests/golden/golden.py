#!/usr/bin/env python3
"""The numbers that every verb gives on the fixtures, against those that it gave when they were pinned.

    tests/golden/golden.py --check [GROUP|COMMAND ...]   status 1 and a line for each number that differs
    tests/golden/golden.py --make  [GROUP|COMMAND ...]   writes what expected/ lacks, and overwrites nothing

The program is that of HAPTOMETER_PROGRAMS (tests/programs.py). Commands run in a temporary folder with a
link to fixtures/. A word of a command that is the name of an input has that input made there first. The
samples of simulated inputs are pinned by commands of their own (scenes-trial-*): where an input changed,
these differ too. Folders of recordings and scenes of many kinds are made by varied.py.

What a command gives is a set of values by path: the numbers, booleans and nulls of its JSON by JSON
pointer, the length of each list as LIST/#, cells of its tables as /FILE/COLUMN/ROW, and what is in TOML,
NumPy and WAV files that it writes; of texts only units. expected/COMMAND.json holds the exit status and
these values; of a list of more than LONGEST entries LONGEST that are evenly spaced. A value that is
expected and missing differs; one that is new does not.

commands.toml
  texts.NAME    a scene or the like: what the file `base` holds before `until`, then `text`; `needs` inputs
  made.NAME     the command that writes an input; those in closed form are below (FORMS)
  command       name (its group before the first -), run, files (that it writes and that are compared),
                longest (in place of LONGEST), each (a folder: runs once with each of its files for {}; what
                that gives stands under /NAME of the file, with its exit status)
  excluded      values that are not compared: commands, paths, because
  looser        values that are compared with another bound: see below
renamed.toml    for each pattern of commands a table: "old pattern" = "new pattern", or "old pattern" =
                {gone = "reason"}. What stars of the old pattern stand for is put for those of the new one.
accepted.toml   [[accepted]] entries of the form of `looser`, which are looked at before those: results
                that were changed on purpose.

Patterns: * is anything within one part of a path or in a command's name, ** any number of parts.
Bounds: floats agree to 1e-12 of the expected value, other values exactly. An entry of `looser` or
`accepted` allows the largest of relative (to the expected value), absolute, and uncertainties (of the
expected standard uncertainty of the value); or a factor; or any = true. The first that names a value holds.
"""
import ast
import cmath
import csv
import functools
import io
import json
import math
import os
import pathlib
import random
import re
import shlex
import struct
import subprocess
import sys
import tempfile
import tomllib

FOLDER = pathlib.Path(__file__).resolve().parent
ROOT = FOLDER.parents[1]
sys.path[:0] = [str(ROOT / "tests"), str(FOLDER)]
import varied  # noqa: E402
from programs import DEADLINE_S, check, program  # noqa: E402

LONGEST = 12          # entries of one list that are pinned
MOST_LINES = 40       # differences of one command that are told
RELATIVE = 1e-12      # rounding of some 1000 operations


def impedance():
    """Coil and moving mass, case held: R + jwL + Km^2 jw / (Kv - Mv w^2 + jw Bv), with 0.1 % of noise."""
    draw = random.Random(1)
    lines = ["frequency_hz,impedance_ohm,phase_deg"]
    for n in range(60):
        f = 60 * (500 / 60) ** (n / 59)
        s = 2j * math.pi * f
        z = 27 + s * 130e-6 + s / (2800 + 1.4e-3 * s**2 + 0.0322 * s)
        z *= complex(1 + draw.gauss(0, 1e-3), draw.gauss(0, 1e-3))
        lines.append(f"{f:.9g},{abs(z):.9g},{math.degrees(cmath.phase(z)):.9g}")
    return "\n".join(lines) + "\n"


def tap(seed, frequency_hz):
    """The ringing of an adapter that was tapped: 2 kHz, 1 s, 0.5 um of noise."""
    draw, s = random.Random(seed), complex(-6, 2 * math.pi * frequency_hz)
    rows = [f"{n / 2000:.4f},{1e-4 * cmath.exp(s * n / 2000).real + draw.gauss(0, 5e-7):.9e}\n" for n in range(2000)]
    return "time_s,displacement_m\n" + "".join(rows)


def noisy_skin():
    """skin.csv as amplitudes with 0.5 % of noise."""
    draw = random.Random(3)
    lines = ["frequency_hz,displacement_amplitude_um,current_amplitude_ma"]
    for row in csv.DictReader(without_header("skin.csv").splitlines()):
        x, i = (math.sqrt(2) * float(row[key]) * (1 + draw.gauss(0, 5e-3)) for key in ("skin_rms_m", "current_rms_a"))
        lines.append(f"{float(row['drive.frequency_hz']):.9g},{x * 1e6:.9g},{i * 1e3:.9g}")
    return "\n".join(lines) + "\n"


def without_header(path):
    return re.sub("^#.*\n", "", pathlib.Path(path).read_text(), flags=re.M)


def damaged(cut=None, flip=0, bit=0):
    data = bytearray(pathlib.Path("fixtures/recorded_trial.bin").read_bytes())
    data[flip] ^= bit
    return bytes(data[:cut])


def study():
    subprocess.run([sys.executable, ROOT / "fixtures/generate/study.py", "study"], check=True, timeout=DEADLINE_S)
    os.replace("study/sweep.csv", "drive_sweep.csv")


def pairs():
    """A calibration: 1.02 mm/V over +-4 mm, up and down, with 1 mV of noise."""
    draw, places = random.Random(8), [*range(-4, 5), *range(3, -5, -1)]
    return "displacement_mm,voltage_v\n" + "".join(f"{mm},{(mm - 0.3) / 1.02 + draw.gauss(0, 1e-3):.6f}\n"
                                                   for mm in places)


FORMS = {  # what makes an input, and the inputs that it needs
    "impedance.csv": (impedance,),
    "pairs.csv": (pairs,),
    "tap1.csv": (lambda: tap(1, 214),),
    "tap2.csv": (lambda: tap(2, 214.3),),
    "skin_noisy.csv": (noisy_skin, "skin.csv"),
    "plain.csv": (lambda: without_header("fixtures/impulse.csv"),),
    "plain_33ohm.csv": (lambda: without_header("fixtures/impulse_33ohm.csv"),),
    "cut.bin": (lambda: damaged(cut=100000),),
    "flipped.bin": (lambda: damaged(flip=60000, bit=1),),
    "half.csv": (lambda: pathlib.Path("whole.csv").read_text().partition("\n6,")[0] + "\n6,1", "whole.csv"),
    "volts.txt": (lambda: "voltage_v\n" + "".join(f"{3 * math.sin(n * n / 300):.6f}\n" for n in range(100)),),
    "sine.f64": (lambda: struct.pack("<10000d", *(50 * math.sin(n / 7) for n in range(10000))),),
    "rows.txt": (lambda: "".join(f"{0.05 * math.sin(n / 7):.6f},{n / 100 - 2:.4f}\n" for n in range(500)),),
    "study": (study,),
    "drive_sweep.csv": (lambda: None, "study"),
    "varied_records": (lambda: varied.tables("varied_records", 48, varied.record),),
    "varied_tables": (lambda: varied.tables("varied_tables", 64, varied.table),),
    "varied_drops": (lambda: varied.tables("varied_drops", 32, varied.drop),),
    "varied_impedances": (lambda: varied.tables("varied_impedances", 16, varied.impedance),),
    "varied_taps": (lambda: varied.tables("varied_taps", 16, varied.tap),),
    "varied_scenes": (lambda: varied.scenes("varied_scenes", 56),),
}


class Inputs:
    """Makes inputs in the current folder, each once."""

    def __init__(self, table):
        self.texts, self.made, self.there = table["texts"], table["made"], set()

    def want(self, words):
        for name in {word.removeprefix("scene:").split("/")[0] for word in words} - self.there:
            self.there.add(name)
            self.make(name)

    def make(self, name):
        if name in self.texts:
            text = self.texts[name]
            self.want(text.get("needs", []))
            base = pathlib.Path(text["base"]).read_text() if "base" in text else ""
            pathlib.Path(name).write_text(base.partition(text.get("until", "\0"))[0] + text["text"])
        elif name in self.made:
            words = shlex.split(self.made[name])
            self.want(words)
            done = execute(words)
            check(done.returncode == 0, f"the input {name} is not made: {done.stderr.decode()}")
        elif name in FORMS:
            form, *needs = FORMS[name]
            self.want(needs)
            content = form()
            if content is not None:
                pathlib.Path(name).write_bytes(content if isinstance(content, bytes) else content.encode())


# --- values by path ---

def execute(words):
    return subprocess.run([program("haptometer"), *words], stdin=subprocess.DEVNULL, capture_output=True,
                          timeout=DEADLINE_S)


def leaves(value, path=""):
    """Pairs of path and value; the length of a list, but of texts, stands under `#`."""
    if isinstance(value, dict):
        for key, item in value.items():
            yield from leaves(item, f"{path}/{key.replace('~', '~0').replace('/', '~1')}")
    elif isinstance(value, list):
        if not value or not all(isinstance(item, str) for item in value):
            yield path + "/#", len(value)
        for index, item in enumerate(value):
            yield from leaves(item, f"{path}/{index}")
    elif not isinstance(value, str) or path.endswith("/unit"):
        yield path, None if value != value else value


def table_columns(text):
    def cell(text):
        return float(text) if re.fullmatch(r"[-+]?\d*\.?\d+([eE][-+]?\d+)?", text) else text or None
    rows = list(csv.reader(line for line in io.StringIO(text) if not line.startswith("#")))
    return {name: [cell(row[i]) for row in rows[1:]] for i, name in enumerate(rows[0])} if rows else {}


def numpy_columns(data):
    size = struct.unpack_from("<H", data, 8)[0]
    head = ast.literal_eval(data[10:10 + size].decode())
    kinds = head["descr"]
    row = struct.Struct("<" + "".join({"<f8": "d", "|u1": "B"}[kind] for _, kind in kinds))
    # a second array behind the rows describes them
    rows = row.iter_unpack(data[10 + size:10 + size + head["shape"][0] * row.size])
    return {name: list(column) for (name, _), column in zip(kinds, zip(*rows))}


def wav_samples(data):
    at = 12
    while data[at:at + 4] != b"data":
        at += 8 + struct.unpack_from("<I", data, at + 4)[0]
    return list(struct.unpack_from(f"<{struct.unpack_from('<I', data, at + 4)[0] // 8}d", data, at + 8))


READERS = {".csv": lambda data: table_columns(data.decode()), ".npy": numpy_columns, ".wav": wav_samples,
           ".toml": lambda data: tomllib.loads(data.decode())}


def run_once(words, outputs):
    """Exit status and values of one run; a table on standard output stands under `stdout`."""
    done = execute(words)
    said = done.stdout.decode()
    values = json.loads(said) if said.startswith("{") else {"stdout": table_columns(said)}
    for path in filter(pathlib.Path.exists, map(pathlib.Path, outputs)):
        values[path.name] = READERS[path.suffix](path.read_bytes())
    return done.returncode, values


def answer(command, inputs):
    """Exit status, and the values by path, of a command."""
    words, outputs = shlex.split(command["run"]), command.get("files", [])
    inputs.want([*words, command.get("each", "")])
    if "each" in command:
        status, values = 0, {}
        for path in sorted(pathlib.Path(command["each"]).iterdir()):
            once, values[path.name] = run_once([word.replace("{}", str(path)) for word in words], outputs)
            values[path.name]["status"] = once
    else:
        status, values = run_once(words, outputs)
    return status, dict(leaves(values))


def is_pinned(path, values, longest):
    """Whether expected/ holds the value: no long list has it between the entries that are chosen."""
    for end in re.finditer(r"/(\d+)(?=/|$)", path):
        length = values.get(path[:end.start()] + "/#", 0)
        if length > longest and int(end[1]) not in {round(k * (length - 1) / (longest - 1)) for k in range(longest)}:
            return False
    return True


# --- comparison ---

@functools.cache
def pattern(text):
    """What a pattern matches; each of its stars is a group."""
    stars = {"**": "(.*)", "*": "([^/]*)"}
    return re.compile("".join(stars.get(part, re.escape(part)) for part in re.split(r"(\*\*|\*)", text)))


def first_rule(rules, name, path):
    """The first rule that names the value."""
    return next((rule for rule in rules if any(pattern(text).fullmatch(name) for text in rule["commands"])
                 and any(pattern(text).fullmatch(path) for text in rule["paths"])), None)


def uncertainty(path, values):
    """The standard uncertainty that belongs to a value, or 0."""
    parent, _, leaf = path.rpartition("/")
    parts = leaf.split("_")
    beside = ["combined_standard_uncertainty", "standard_uncertainty"]
    beside += ["_".join([*parts[:i], "standard_uncertainty", *parts[i:]]) for i in range(len(parts), 0, -1)]
    return next((values[f"{parent}/{key}"] for key in beside if isinstance(values.get(f"{parent}/{key}"), float)), 0)


def agree(old, new, rule, standard_uncertainty):
    """Whether a value is the expected one within the bound of the rule."""
    if rule.get("any") or type(old) is type(new) and old == new:
        return True
    if any(isinstance(value, (bool, str, type(None))) for value in (old, new)):
        return False
    if "factor" in rule and old * new > 0 and max(old / new, new / old) <= rule["factor"]:
        return True
    relative = rule.get("relative", 0 if isinstance(old, int) else RELATIVE)
    return abs(new - old) <= max(relative * abs(old), rule.get("absolute", 0),
                                 rule.get("uncertainties", 0) * standard_uncertainty)


def present_path(name, path, renamed):
    """The path that a value has now; None where it is gone."""
    for commands, table in renamed.items():
        for old, new in table.items() if pattern(commands).fullmatch(name) else ():
            found = pattern(old).fullmatch(path)
            if found:
                parts = iter(found.groups())
                return None if isinstance(new, dict) else re.sub(r"\*\*|\*", lambda _: next(parts), new)
    return path


def differences(name, expected, status, values, rules):
    """Lines that say what of a command is no longer as expected."""
    if status != expected["status"]:
        yield f"{name}: exit status: was {expected['status']}, is {status}"
    for path, old in expected["values"].items():
        now = present_path(name, path, rules["renamed"])
        if now is None or old is None and now not in values or first_rule(rules["excluded"], name, path):
            continue
        called = path if now == path else f"{path}, now {now}"
        rule = first_rule(rules["bounds"], name, path) or {}
        if now not in values:
            yield f"{name}: {called}: was {old!r}, is missing"
        elif not agree(old, values[now], rule, uncertainty(path, expected["values"])):
            numbers = old and all(type(value) in (int, float) for value in (old, values[now]))
            ratio = f", relative difference {abs(values[now] - old) / abs(old):.3g}" if numbers else ""
            yield f"{name}: {called}: was {old!r}, is {values[now]!r}{ratio}"


def read_rules(table):
    accepted = tomllib.loads((FOLDER / "accepted.toml").read_text()).get("accepted", [])
    for rule in accepted + table["looser"] + table["excluded"]:
        check(rule.keys() >= {"commands", "paths", "because"}, f"commands, paths and because are needed: {rule}")
    return {"renamed": tomllib.loads((FOLDER / "renamed.toml").read_text()),
            "bounds": accepted + table["looser"], "excluded": table["excluded"]}


def make(command, path, inputs, rules):
    if path.exists():
        print(f"{command['name']}: is there, and is not made again")
        return
    status, values = answer(command, inputs)
    kept = [f"    {json.dumps(at)}: {json.dumps(values[at])}" for at in sorted(values)
            if is_pinned(at, values, command.get("longest", LONGEST))
            and not first_rule(rules["excluded"], command["name"], at)]
    head = f'  "command": {json.dumps(command["run"])},\n  "status": {status},\n  "values": '
    path.write_text("{\n" + head + "{\n" + ",\n".join(kept) + "\n  }\n}\n")
    print(f"{command['name']}: status {status}, {len(kept)} values")


def main():
    check(len(sys.argv) > 1 and sys.argv[1] in ("--check", "--make"), __doc__)
    names, found = sys.argv[2:], []
    table = tomllib.loads((FOLDER / "commands.toml").read_text())
    commands = [command for command in table["command"]
                if not names or command["name"] in names or command["name"].split("-")[0] in names]
    check(commands, f"no command and no group is called {names}")
    rules, inputs, compared = read_rules(table), Inputs(table), 0
    os.environ["HAPTOMETER_PROGRAMS"] = os.path.dirname(program("haptometer"))
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        os.symlink(ROOT / "fixtures", "fixtures")
        for command in commands:
            path = FOLDER / "expected" / (command["name"] + ".json")
            if sys.argv[1] == "--make":
                make(command, path, inputs, rules)
            else:
                expected = json.loads(path.read_text())
                lines = list(differences(command["name"], expected, *answer(command, inputs), rules))
                found += lines[:MOST_LINES] + [f"... and {len(lines) - MOST_LINES} more"] * (len(lines) > MOST_LINES)
                compared += len(expected["values"])
        os.chdir(ROOT)
    print("\n".join([*found, f"{len(commands)} commands, {compared} values compared"]))
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
