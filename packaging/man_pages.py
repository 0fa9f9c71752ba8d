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

LINE = 74  # characters of an example before it is continued on the next line
LONG = 40  # characters of choices that still stand behind the option itself
SPECIAL = {"\\": r"\(rs", "-": r"\-", "'": r"\(aq", "`": r"\(ga", "^": r"\(ha", "~": r"\(ti", '"': r"\(dq"}
OPTIONS = """\
A quantity has a unit, as in 10mm or 225Hz; the unit behind an option is the one that may be left out or, of a length, \
a mass and an inductance, the SI unit. What holds without an option is its default."""
MEANINGS = {
    "0": "The question is answered.",
    "1": "The run failed: a full disk (also behind standard output), a lost device.",
    "2": "The command line, or a key of a scene, is wrong.",
    "3": "The file or device cannot answer: it is missing, empty, of another kind, too slow, absent or busy.",
    "130, 143, 129": "Ctrl-C, SIGTERM or a closed terminal ended the run. What was recorded until then is kept.",
    "141": "Standard output was closed. There is no message.",
}


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


def examples_of(verb, title):
    """Commands, those that are too long continued behind a backslash."""
    text = title
    for example in verb["examples"]:
        lines = [""]
        for word in re.findall(r"(?:'[^']*'|[^ ])+", example):
            if lines[-1] and len(lines[-1]) + len(word) > LINE:
                lines.append("   ")
            lines[-1] += (" " if lines[-1] else "") + word
        text += ".PP\n.EX\n" + " \\(rs\n".join(map(escaped, lines)) + "\n.EE\n"
    return text if verb["examples"] else ""


def arguments_of(verb):
    return "".join(item(italic(one["name"]) + ("..." if one["repeatable"] else ""), one["text"])
                   for one in verb["positionals"])


def beginning(name, summary, version):
    title = escaped(name.upper())
    # no word is broken or stretched, so that it can be copied
    return (f'.\\" written by packaging/man_pages.py\n.TH {title} 1 "" "{escaped(version)}" "haptometer manual"\n'
            f".nh\n.ad l\n.SH NAME\n{escaped(name)} \\- {escaped(summary)}\n")


def exit_status():
    return ".SH EXIT STATUS\n" + "".join(item(bold(status), text) for status, text in MEANINGS.items())


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
    return text + ".SH SEE ALSO\n" + bold("haptometer") + "(1)\n"


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
    text += ".SH OPTIONS\n" + line(OPTIONS) + exit_status() + ".SH SEE ALSO\n"
    return text + ",\n".join(bold("haptometer-" + verb["name"]) + "(1)" for verb in verbs) + "\n"


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
