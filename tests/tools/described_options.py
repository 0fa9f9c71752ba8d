#!/usr/bin/env python3
"""Every option as `haptometer --describe-options` has it: its bounds are those that the command line
holds, each verb's examples are taken, and the tables of docs/reference/ name every option and no other.
"""
import json
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))
from programs import DEADLINE_S, check, program  # noqa: E402

DESCRIBE = "--describe-options"
ALIKE = {"--help", "--help-all", "--version", "--json"}  # common.md
# where a verb's options are, if not on the page of its name
PAGES = {"acquire": ["acquire.md", "daemon.md"]}
# tables of a scene with which the reader knows all keys of the table
TABLES = {
    "coil_heating": ["heat_capacity_j_per_k = 1"],
    "drive": ['kind = "sine"\namplitude_v = 5\nfrequency_hz = 225',
              'kind = "burst"\namplitude_v = 5\nfrequency_hz = 225\nhold_s = 0.01',
              'kind = "chirp"\namplitude_v = 5\nfrequency_hz = 225\nend_frequency_hz = 300\nduration_s = 0.01',
              'kind = "samples"\nrate_hz = 1000\nfile = "volts.txt"'],
    "mounting": ['kind = "drop"\nheight_m = 0.01', 'kind = "grip"\nstiffness_n_per_m = 1\ndamping_n_s_per_m = 1'],
    "sensor": ['kind = "ideal"'],
    "skin": ["stiffness_n_per_m = 600\ndamping_n_s_per_m = 0.75",
             'contact_area_m2 = 1e-6\nlaw = "power"\nrange = "text"'],
    "stiffening": ["cubic_n_per_m3 = 1e6"],
    "travel_stops": ["gap_m = 1e-3\nrestitution = 0.5"],
    "tremor": ["amplitude_m = 1e-5\nfrequency_hz = 8"],
}
CONSTANTS = {"gravity", "travel_stops", "stiffening", "tremor", "coil_heating"}  # of effects
EXACT = 2**53  # bounds are doubles, which are no exact whole numbers from here on
STEP = 1e-3  # by how much a value lies outside, relative to the bound


def answer(words):
    return subprocess.run([program("haptometer"), *words], capture_output=True, text=True, timeout=DEADLINE_S)


def names_of(option):
    """"-o,--output" is --output."""
    return [name for name in option["name"].split(",") if name.startswith("--")]


def name_of(option):
    return names_of(option)[0]


def text_of(option, number):
    if option["kind"] == "count":
        return str(number)
    return repr(number) + (option["unit"] or "").replace(" ", "")


def values(option):
    """Numbers on and beside each end, and whether they are taken."""
    whole = option["kind"] == "count"
    for end, sign, is_open in (("least", -1, option["above"]), ("most", 1, option["below"])):
        number = option[end]
        if number is None or (whole and abs(number) >= EXACT):
            continue
        number = round(number) if whole else number
        beyond = number + sign if whole else number + sign * STEP * (abs(number) or 1)
        yield number, not is_open
        yield beyond, False


def check_bounds(verb, option):
    count = 0
    for number, is_taken in values(option):
        done = answer([*verb["name"].split(), name_of(option), text_of(option, number), DESCRIBE])
        what = f"{verb['name']} {name_of(option)} {text_of(option, number)}: {done.stderr}"
        check(done.returncode == (0 if is_taken else 2), what)
        check(is_taken or name_of(option) in done.stderr, what)
        count += 1
    return count


def check_examples(verb):
    for example in verb["examples"]:
        words = shlex.split(example.split("|")[0])
        words = words[words[0] == "haptometer":]
        # what stands behind -- is no option of the verb
        end = words.index("--") if "--" in words else len(words)
        done = answer([*words[:end], DESCRIBE, *words[end:]])
        check(done.returncode == 0, f"{example}: {done.stderr}")


def options_of_page(name):
    """The options in the first column of the tables that are of options."""
    names, in_table = set(), False
    for line in (ROOT / "docs/reference" / name).read_text().splitlines():
        cells = re.split(r"(?<!\\)\|", line)
        if len(cells) < 3:
            in_table = False
        elif not in_table:
            in_table = cells[1].strip().startswith("option")
        if in_table:
            names |= set(re.findall(r"`(?:-\w, )?(--[a-z][a-z0-9-]*)", cells[1]))
            names |= set(re.findall(r"(?<=[ ,`])(--[a-z][a-z0-9-]*)", cells[1]))
    return names


def check_pages(verbs):
    options = {}
    for verb in verbs:
        options.setdefault(verb["name"].split()[0], []).extend(verb["options"])
    wrong = []
    for word, of_word in options.items():
        said = set().union(*(options_of_page(page) for page in PAGES.get(word, [word + ".md"]))) - ALIKE
        missing = {name_of(option) for option in of_word if not said.intersection(names_of(option))}
        unknown = said.difference(*map(names_of, of_word))
        if missing:
            wrong.append(f"{word}: no table names {' '.join(sorted(missing))}")
        if unknown:
            wrong.append(f"{word}: a table names {' '.join(sorted(unknown))}, which is no option")
    check(not wrong, "\n".join(wrong))


def keys_of_page():
    """The keys in the tables of the page on scenes, as "drive.frequency_hz"; not of [[drive.tone]]."""
    keys, table = {"drive.kind"}, None  # which a sentence names
    for line in (ROOT / "docs/reference/scene.md").read_text().splitlines():
        if heading := re.match(r"## \[(\w+)\]$", line):
            table = heading[1]
        elif line.startswith("## "):
            table = None
        cells = [cell.strip() for cell in line.split("|")[1:]]
        if len(cells) < 2:
            continue
        if named := re.match(r"key of `\[(\w+)\]`", cells[0]):
            table = named[1]
        elif cells[0] == "table":
            table = "of each row"
        cell = cells[0]
        if table == "of each row" or table in CONSTANTS:
            if named := re.match(r"`\[(\w+)\]`", cells[0]):
                table = named[1]
            cell = cells[1]
        if table and "." not in table:
            keys |= {f"{table}.{key}" for key in re.findall(r"(?:^|, |or )`([a-z][a-z0-9_]*)`", cell)}
    return keys


def is_known(key, folder):
    """Whether the reader of scenes knows the key in one of the forms of its table."""
    table, name = key.split(".")
    scene = folder / "scene.toml"
    for content in TABLES.get(table, [None]):
        text = (ROOT / "fixtures/lra_adapter.toml").read_text()
        if content:
            text = re.sub(rf"(?ms)^\[{table}\]\n.*?(?=^\[|\Z)", "", text) + f"\n[{table}]\n{content}\n"
        scene.write_text(text)
        done = answer(["sweep", str(scene), "--vary", f"{key}=1,2", "-o", str(folder / "table.csv"), "--overwrite"])
        if f"key {name} is not known" not in done.stderr:
            return True
    return False


def check_keys(verbs):
    """The keys of a scene that a shell completes are those of the page, and those that the reader knows."""
    known, = [option["known"] for verb in verbs for option in verb["options"]
              if (verb["name"], option["name"]) == ("sweep", "--vary")]
    page = keys_of_page()
    check(set(known) == page, f"only completed: {set(known) - page}; only on the page: {page - set(known)}")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "volts.txt").write_text("voltage_v\n0\n1\n")
        for table in sorted({key.split(".")[0] for key in known}):
            check(not is_known(f"{table}.no_such_key", folder), f"the reader takes any key of [{table}]")
        unknown = [key for key in known if not is_known(key, folder)]
    check(not unknown, f"the reader does not know {unknown}")


def main():
    done = answer([DESCRIBE])
    check(done.returncode == 0, done.stderr)
    verbs = json.loads(done.stdout)
    check(len(verbs) > 10, "the verbs are there")
    tried = 0
    for verb in verbs:
        check_examples(verb)
        for option in verb["options"]:
            tried += check_bounds(verb, option)
    check(tried > 60, f"only {tried} values were tried")
    check_pages(verbs)
    check_keys(verbs)
    print(f"{len(verbs)} verbs, {tried} values at and beyond bounds")


if __name__ == "__main__":
    main()
