#!/usr/bin/env python3
"""Pinned numbers, and the same ones from each processor and compiler: the commands of golden.py.

    tests/golden/same_bytes.py --check [GROUP ...]  what `golden.py --check` compares; simulate, sweep and tune (EXACT)
                                                    give the very bits of digests.json; and all of it once more without
                                                    what only some processors have: EXACT with the same bits, the
                                                    others, in which FFTW, BLAS and Ceres take part, within a thousandth
                                                    of their standard uncertainties, or as golden.py allows
    tests/golden/same_bytes.py --as-built           EXACT's bits alone, in the environment as it is: for builds of other
                                                    compilers and flags
    tests/golden/same_bytes.py --make               writes digests.json, after a change of the arithmetic

A digest is that of a command's exit status and all its values (golden.py says which), floats with all their digits.
Each x86-64 has neither the C library's functions that use fused products, nor kernels of the filters above SSE2. (Of
the kernels of the other instruction sets dsp_filter ZeroPhaseBlocks.EveryInstructionSetGivesTheSameBytes.)
"""
import hashlib
import json
import os
import sys
import tempfile
import tomllib

import golden
from programs import check, program

DIGESTS = golden.FOLDER / "digests.json"
EXACT = ("scenes", "sweep", "tune")
EACH_X86_64 = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX512F,-AVX2_Usable",
               "HAPTOMETER_INSTRUCTION_SET": "sse2"}
UNCERTAINTIES = 1e-3


def is_exact(command):
    return command["name"].split("-")[0] in EXACT


def answers(commands, table, rules, environment):
    """Exit status and values of each command by its name, in a folder of their own."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        os.symlink(golden.ROOT / "fixtures", "fixtures")
        os.environ.update(environment)
        inputs = golden.Inputs(table)
        for command in commands:
            name = command["name"]
            status, values = golden.answer(command, inputs)
            found[name] = status, {path: value for path, value in values.items()
                                   if not golden.first_rule(rules["excluded"], name, path)}
        for key in environment:
            del os.environ[key]
        os.chdir(golden.ROOT)
    return found


def digest(answer):
    return hashlib.sha256(json.dumps(answer, sort_keys=True).encode()).hexdigest()[:16]


def disagreements(name, first, other, rules):
    """Lines on the values that differ by more than they may."""
    if first[0] != other[0] or first[1].keys() != other[1].keys():
        yield f"{name}: exit status or the set of values"
        return
    for path, old in first[1].items():
        rule = golden.first_rule(rules["bounds"], name, path) or {"uncertainties": UNCERTAINTIES}
        if not golden.agree(old, other[1][path], rule, golden.uncertainty(path, first[1])):
            yield f"{name}: {path}: {old!r} and {other[1][path]!r}"


def as_pinned(commands, found, rules):
    """Lines on the values that differ from those of expected/."""
    for name in (command["name"] for command in commands):
        expected = json.loads((golden.FOLDER / "expected" / f"{name}.json").read_text(encoding="utf-8"))
        yield from list(golden.differences(name, expected, *found[name], rules))[:golden.MOST_LINES]


def main():
    what, *groups = sys.argv[1:] or [""]
    check(what == "--check" or what in ("--as-built", "--make") and not groups, __doc__)
    table = tomllib.loads((golden.FOLDER / "commands.toml").read_text())
    rules = golden.read_rules(table)
    os.environ["HAPTOMETER_PROGRAMS"] = os.path.dirname(program("haptometer"))
    commands = [command for command in table["command"] if is_exact(command) or what == "--check"]
    every = sorted(command["name"] for command in commands if is_exact(command))
    commands = [command for command in commands if not groups or command["name"].split("-")[0] in groups]
    check(commands, f"no group is called {groups}")
    exact = [command["name"] for command in commands if is_exact(command)]
    first = answers(commands, table, rules, {})
    if what == "--make":
        digests = {name: digest(first[name]) for name in every}
        DIGESTS.write_text(json.dumps(digests, indent=1) + "\n", encoding="utf-8")
        return
    digests = json.loads(DIGESTS.read_text(encoding="utf-8"))
    check(sorted(digests) == every, "digests.json is of other commands; --make writes it anew")
    lost = [f"as it is: {name}: other bits" for name in exact if digest(first[name]) != digests[name]]
    if what == "--check":
        lost += as_pinned(commands, first, rules)
        there = answers(commands, table, rules, EACH_X86_64)
        lost += [f"each x86-64: {name}: other bits" for name in exact if digest(there[name]) != digests[name]]
        for name in there.keys() - set(exact):
            lost += [f"each x86-64: {line}" for line in disagreements(name, first[name], there[name], rules)]
    print("\n".join([*lost, f"{len(exact)} commands with the same bits, {len(commands) - len(exact)} that agree"]))
    sys.exit(1 if lost else 0)


if __name__ == "__main__":
    main()
