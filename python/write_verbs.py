#!/usr/bin/env python3
"""python/write_verbs.py PROGRAM FILE

Writes FILE, the functions of the package haptometer that call verbs, from what `PROGRAM --describe-options` says: a
parameter for each option, with its unit and bounds in the docstring.
"""
import json
import keyword
import pathlib
import re
import subprocess
import sys
import textwrap

# they talk to devices, terminals and schedulers: what they do is done by the commands
COMMANDS = {"acquire", "campaign", "emulate", "session"}
ANSWERS = {"analyze": "Analysis", "fit-lra": "Fit", "fit-impedance": "Fit", "simulate": "Simulation", "sweep": "Sweep"}
# the document has everything, and pictures of it are drawn by its own methods
CHANGES = {"trial label", "trial exclude", "trial include"}  # a file that is given
WRITERS = {"trial export", "trial plot"}  # of a file, without another answer
WITHOUT_PANELS = {"simulate", "reproduce", "analyze"}  # they would add a run, or a picture of each trial
LEFT_OUT = {"--all", "--plan", "--impedance", "--adapter", "--slurm", "--job-time", "--campaign"}
HEAD = '''\
"""The verbs, written by python/write_verbs.py from the options that the program declares."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

from haptometer._words import (File, Files, Labels, Number, Option, Pair, Path, Texts, Values, call, call_sweep,
                               call_writer, on_disk, texts)
from haptometer.answer import Analysis, Answer, Fit, Simulation, Sweep
'''


def name_of(words):
    """--drop-height is drop_height, "-o,--output" output."""
    first = next((word for word in words.split(",") if word.startswith("--")), words)
    name = first.lstrip("-").replace("-", "_").replace(" ", "_")
    return name + "_" if keyword.iskeyword(name) else name


def long_name(option):
    return next(word for word in option["name"].split(",") if word.startswith("--"))


def is_pair(placeholder):
    return re.fullmatch(r"(auto\|all\|)?[A-Z]+[:-][A-Z]+(Hz)?|20-500Hz", placeholder or "")


def takes_pair(option):
    return option["kind"] == "range" or is_pair(option["placeholder"]) and not option["repeatable"]


def type_of(option):
    """The type of a parameter."""
    placeholder = option["placeholder"] or ""
    if option["kind"] == "flag":
        return "bool"
    if option["kind"] == "count":
        return "int | None"
    if option["kind"] == "number":
        return "Number | None"
    if option["kind"] == "choice":
        return f"Literal[{', '.join(map(json.dumps, option['choices']))}] | None"
    if takes_pair(option):
        return "Pair | None"
    if option["several"]:
        keyed = placeholder.startswith("OHM ")
        return "Mapping[float | str, Files] | None" if keyed else "Files | None"
    if "=" in placeholder:
        return "Mapping[str, Values] | Texts | None"
    if re.search("FILE|PATH|DIR", placeholder):
        one = "File" if "bin" in placeholder or "toml" in placeholder else "Path"
        return f"{one} | Sequence[{one}] | None" if option["repeatable"] else f"{one} | None"
    if option["optional"]:
        return "bool | str"
    return "Texts | None" if option["repeatable"] else "Values | None"


def parameter(option):
    kind = type_of(option)
    return f"{name_of(option['name'])}: {kind} = {'False' if kind.startswith('bool') else 'None'}"


def spec(option):
    """The Option of a parameter."""
    words = [json.dumps(long_name(option)), name_of(option["name"])]
    if (option["placeholder"] or "").startswith("OHM "):
        words.append('"ohm"')
    elif option["unit"]:
        words.append(json.dumps(option["unit"]))
    if takes_pair(option):
        words.append("is_pair=True")
        words += ['between="-"', 'ending="Hz"'] if "Hz" in option["placeholder"] and not option["unit"] else []
    words += ["is_list=True"] if option["several"] else []
    words += ["is_repeated=True"] if option["repeatable"] else []
    words += ["is_flag=True"] if option["kind"] == "flag" or option["optional"] else []
    return f"Option({', '.join(words)})"


def wrapped(text, indent):
    return textwrap.fill(text, 116, initial_indent=indent, subsequent_indent=indent)


def shape_of(option):
    """What the docstring says of the value."""
    kinds = {"flag": "bool", "count": "int", "number": "float, Quantity or str", "choice": "str", "range": "(float, float)"}
    word = kinds.get(option["kind"], option["placeholder"] or "str")
    return word + (f", {option['unit']}" if option["unit"] else "")


def docstring(verb, options, words, answer):
    """NumPy's style."""
    lines = ['    """' + verb["summary"], "", "    Parameters", "    ----------"]
    for one in words:
        lines += [f"    {name_of(one['name'])} : {'file or files' if one['repeatable'] else 'file or str'}",
                  wrapped(one["text"] + ".", " " * 8)]
    for option in options:
        added = [part for part in (option["bounds"], option["default"] and "default " + option["default"]) if part]
        text = option["text"] + (f" [{'; '.join(added)}]" if added else "")
        lines += [f"    {name_of(option['name'])} : {shape_of(option)}", wrapped(text + ".", " " * 8)]
    if answer:
        lines += ["    panels : bool", "        Whether panels for plot() and the page are computed."]
        lines += ["", "    Returns", "    -------", f"    {answer}", "        The document that the command prints with --json."]
    lines += ["", "    Raises", "    ------", "    UsageError, CannotAnswerError, HaptometerError",
              "        It failed; the text is what the command prints. A refusal is an answer.", '    """']
    return "\n".join(line.replace("\\", "\\\\") for line in lines)


def is_text(one):
    return "key=" in one["text"] or "KEY=" in one["text"] or one["name"] == "question"


def positional_type(one, verb):
    if is_text(one):
        return "Labels" if one["required"] else "Labels | None"
    if one["repeatable"]:
        return "Files" if one["required"] else "Files | None"
    kind = "Path" if verb["name"] in CHANGES else "File"
    return kind if one["required"] and verb["name"] != "sweep" else f"{kind} | None"


def function(verb, name, answer, words, one_file=False):
    """The source of one function."""
    options = [option for option in verb["options"] if not LEFT_OUT & set(option["name"].split(","))]
    positional = []
    for one in words:
        kind = "File" if one_file else positional_type(one, verb)
        default = "" if one["required"] and "None" not in kind else " = None"
        positional.append(f"{'file' if one_file else name_of(one['name'])}: {kind}{default}")
    parameters = [*positional, "*", *map(parameter, options), f"panels: bool = {one_file or verb['name'] not in WITHOUT_PANELS}"]
    shown = [dict(one, name="file", repeatable=False) for one in words] if one_file else words
    files = []
    for one in shown:
        word = name_of(one["name"])
        files.append(f"texts({word})" if is_text(one) else f"on_disk({word})" if verb["name"] in CHANGES else word)
    verb_words = json.dumps(verb["name"].split())
    if verb["name"] in WRITERS:
        parameters.pop()
        body = ",\n        ".join(map(spec, options))
        return (f"\n\ndef {name}(\n    " + ",\n    ".join(parameters) + ",\n) -> None:\n"
                + docstring(verb, options, shown, None)
                + f"\n    call_writer({verb_words}, [{', '.join(files)}], [\n        {body},\n    ])\n")
    call = f"call_sweep({verb_words}" if answer == "Sweep" else f"call({answer}, {verb_words}"
    body = ",\n        ".join(map(spec, options))
    return (f"\n\ndef {name}(\n    " + ",\n    ".join(parameters) + f",\n) -> {answer}:\n"
            + docstring(verb, options, shown, answer)
            + f"\n    return {call}, [{', '.join(files)}], [\n        {body},\n    ], panels)\n")


def main(program, path):
    described = json.loads(subprocess.run([program, "--describe-options"], check=True, capture_output=True).stdout)
    text, names = HEAD, []
    for verb in described:
        if verb["name"].split()[0] in COMMANDS or not verb["options"] and not verb["positionals"]:
            continue
        name, answer = name_of(verb["name"]), ANSWERS.get(verb["name"], "Answer")
        if verb["name"] == "analyze":
            text += function(verb, "analyze", answer, verb["positionals"], one_file=True)
            name, answer = "analyze_many", "Answer"
            names.append("analyze")
        text += function(verb, name, answer, verb["positionals"])
        names.append(name)
    text += "\n\n__all__ = [" + ", ".join(json.dumps(name) for name in sorted(names)) + "]\n"
    pathlib.Path(path).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
