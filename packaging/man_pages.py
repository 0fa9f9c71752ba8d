#!/usr/bin/env python3
"""packaging/man_pages.py PROGRAM FOLDER [OWN_NAME...]

Writes the manual pages of the program: haptometer.1, and haptometer-VERB.1 of each verb, from what
`PROGRAM --describe-options` says. Parts of a verb (`trial info`) are sections of its page. Each OWN_NAME is a verb that
is installed under its own name too; its page refers to that of the verb.
"""
import json
import pathlib
import re
import subprocess
import sys

from completion import BEHIND_DASHES

COMMON = pathlib.Path(__file__).parents[1] / "docs/reference/common.md"
LINE = 69  # characters of an example before it is continued on the next line; indented, a line has 80
LONG = 40  # characters of choices that still stand behind the option itself
SPECIAL = {"\\": r"\(rs", "-": r"\-", "'": r"\(aq", "`": r"\(ga", "^": r"\(ha", "~": r"\(ti", '"': r"\(dq"}
OPTIONS = """\
Numbers take a unit, as in 10mm. Hz, s, V, A, ohm and N/m may be left out. Brackets at the end of a text have the bounds \
of a value, its default, which holds where the option is not given, and whether the option may be repeated."""
PLAIN = ".nh\n.ad l\n"  # no word is broken or stretched, so that it can be copied


def escaped(text):
    """Text as it is to be read, whatever it holds."""
    return "".join(SPECIAL.get(c, c if c.isascii() else f"\\[u{ord(c):04X}]") for c in text)


def line(text):
    """A line of its own that roff does not take for a request."""
    return ("\\&" if text.startswith(".") else "") + escaped(text) + "\n"


def bold(text):
    return f"\\fB{escaped(text)}\\fR"


def italic(text):
    return f"\\fI{escaped(text)}\\fR"


def first_sentence(text):
    """"Draw it. See also X." is "Draw it"."""
    return re.split(r"\.(?: |$)", text)[0]


def words_of(verb):
    """Positional arguments, as a synopsis has them."""
    words = []
    for one in verb["positionals"]:
        word = italic(one["name"]) + ("..." if one["repeatable"] else "")
        words.append(word if one["required"] else f"[{word}]")
    return words


def synopsis(verb, name=None):
    command = bold(name or "haptometer " + verb["name"])
    return " ".join([command, f"[{italic('OPTION')}]...", *words_of(verb)]) + "\n"


def value_of(option):
    """What stands behind the name of an option."""
    placeholder = option["placeholder"]
    if option["kind"] == "flag":
        return ""
    if option["kind"] == "choice":
        text = italic("NAME") if len(placeholder) > LONG else "|".join(map(bold, option["choices"]))
    else:
        text = italic(placeholder) + ("..." if option["several"] and not placeholder.endswith("...") else "")
    return f" [{text}]" if option["optional"] else " " + text


def text_of(option):
    text = option["text"]
    if len(option["choices"]) > 0 and len(option["placeholder"]) > LONG:
        text += ": " + ", ".join(option["choices"])
    added = [part for part in (option["bounds"], option["default"] and "default " + option["default"]) if part]
    if option["repeatable"] and "repeated" not in text:
        added.append("may be repeated")
    return text + (f" [{'; '.join(added)}]" if added else "")


def item(tag, text):
    return f".TP\n{tag}\n{line(text)}"


def names(option):
    return ", ".join(bold(name) for name in option["name"].split(","))


def options_of(verb, title):
    """The usual options, and those of --help-all under a title of their own."""
    text = ""
    for heading, is_rare in ((title, False), (".SS More options\n", True)):
        found = [option for option in verb["options"] if option["rare"] == is_rare]
        text += heading if found else ""
        text += "".join(item(names(option) + value_of(option), text_of(option)) for option in found)
    return text


def words_together(example):
    """The words of a command, an option with its value as one."""
    words = []
    for word in re.findall(r"(?:'[^']*'|[^ ])+", example):
        if words and re.fullmatch(r"-[^ =]+", words[-1]) and not word.startswith("-"):
            words[-1] += " " + word
        else:
            words.append(word)
    return words


def lines_of(example):
    """A command, continued where it is too long."""
    lines = [""]
    for word in words_together(example):
        if lines[-1] and len(lines[-1]) + 1 + len(word) > LINE:
            lines.append("   ")
        lines[-1] += (" " if lines[-1] else "") + word
    return lines


def examples_of(verb, title):
    """Commands, those that are too long continued behind a backslash."""
    # .EE sets hyphens and margins as they are by default
    examples = [".PP\n.EX\n" + " \\(rs\n".join(map(escaped, lines_of(example))) + "\n.EE\n" + PLAIN
                for example in verb["examples"]]
    return title + "".join(examples) if examples else ""


def arguments_of(verb):
    return "".join(item(italic(one["name"]) + ("..." if one["repeatable"] else ""), one["text"])
                   for one in verb["positionals"])


def beginning(name, summary, version):
    title = escaped(name.upper())
    return (f'.\\" written by packaging/man_pages.py\n.TH {title} 1 "" "{escaped(version)}" "haptometer manual"\n'
            f"{PLAIN}.SH NAME\n{escaped(name)} \\- {escaped(summary)}\n")


def exit_status():
    """The table of docs/reference/common.md, and the paragraph behind it."""
    said = re.search(r"### Exit status\n\n(?:\|.*\n){2}((?:\|.*\n)+)\n(.*)\n", COMMON.read_text())
    table, behind = said[1].replace("`", "").replace("\\|", "\0"), said[2]
    rows = [[cell.strip().replace("\0", "|") for cell in row.strip("|").split("|")] for row in table.splitlines()]
    return ".SH EXIT STATUS\n" + "".join(item(bold(status), text) for status, text in rows) + ".PP\n" + line(behind)


def see_also(names):
    """Pages by name."""
    return (".SH SEE ALSO\n" + ",\n".join(bold(name) + "(1)" for name in names) + "\n.PP\n" +
            line("The pages docs/reference/*.md are in the source code of haptometer."))


def part_section(part):
    text = f".SH {escaped(part['name'].upper())}\n" + line(part["summary"]) + ".PP\n" + synopsis(part)
    return text + arguments_of(part) + options_of(part, ".SS Options\n") + examples_of(part, ".SS Examples\n")


def verb_page(verb, parts, own, version):
    name = verb["name"]
    text = beginning("haptometer-" + name, first_sentence(verb["summary"]), version) + ".SH SYNOPSIS\n"
    has_own_options = bool(verb["options"])
    lines = ([synopsis(verb)] if has_own_options else []) + [synopsis(part) for part in parts]
    lines += [synopsis(verb, name)] if name in own else []
    text += ".br\n".join(lines)
    text += ".SH DESCRIPTION\n" + line(verb["summary"].removesuffix(".") + ".")
    text += "" if has_own_options else ".PP\n" + line(OPTIONS)
    if has_own_options:
        text += arguments_of(verb) + options_of(verb, ".SH OPTIONS\n" + line(OPTIONS))
    text += "".join(map(part_section, parts))
    text += ".SH COMMON OPTIONS\n" + "".join(item(names(option), option["text"]) for option in verb["common"])
    text += examples_of(verb, ".SH EXAMPLES\n") + exit_status()
    behind = [f"haptometer-{other}" for part, other in BEHIND_DASHES.items() if part.split()[0] == name]
    return text + see_also(["haptometer", *behind])


def program_page(verbs, own, version):
    text = beginning("haptometer", "measure the vibration of tactile actuators by laser", version)
    text += ".SH SYNOPSIS\n" + ".br\n".join([
        f"{bold('haptometer')} {italic('VERB')} [{italic('OPTION')}]... [{italic('ARGUMENT')}]...\n",
        f"{bold('haptometer help')} {italic('VERB')} [{italic('PART')}]\n",
        f"{bold('haptometer')} {bold('--help')}|{bold('--version')}\n"])
    text += ".SH DESCRIPTION\n" + line(
        "haptometer records a distance sensor, gives the vibration within a band with its uncertainty, fits the "
        "constants of an actuator to drop tests, and simulates actuator, adapter and skin. Each verb has a page of its "
        "own.")
    if own:
        text += ".PP\n" + ", ".join(map(bold, own)) + " are also programs of their own.\n"
    text += ".SH VERBS\n"
    text += "".join(item(f"{bold('haptometer-' + verb['name'])}(1)", first_sentence(verb["summary"])) for verb in verbs)
    text += ".SH OPTIONS\n" + item(f"{bold('-h')}, {bold('--help')}", "Show the verbs")
    text += item(bold("--version"), "Show the version") + ".PP\n" + line(OPTIONS)
    return text + exit_status() + see_also(["haptometer-" + verb["name"] for verb in verbs])


def answer(program, option):
    return subprocess.run([program, option], check=True, capture_output=True, text=True).stdout


def main():
    program, folder, *own = sys.argv[1:]
    version = answer(program, "--version").strip()
    described = json.loads(answer(program, "--describe-options"))
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    verbs = [one for one in described if " " not in one["name"]]
    for verb in verbs:
        parts = [one for one in described if one["name"].startswith(verb["name"] + " ")]
        (folder / f"haptometer-{verb['name']}.1").write_text(verb_page(verb, parts, own, version))
    for name in own:
        (folder / f"{name}.1").write_text(f".so man1/haptometer-{name}.1\n")
    (folder / "haptometer.1").write_text(program_page(verbs, own, version))


if __name__ == "__main__":
    main()
