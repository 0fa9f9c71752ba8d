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

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))
from programs import DEADLINE_S, check, program  # noqa: E402

DESCRIBE = "--describe-options"
ALIKE = {"--help", "--help-all", "--version", "--json"}  # common.md
# where a verb's options are, if not on the page of its name
PAGES = {"acquire": ["acquire.md", "daemon.md"]}
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
    print(f"{len(verbs)} verbs, {tried} values at and beyond bounds")


if __name__ == "__main__":
    main()
