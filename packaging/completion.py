#!/usr/bin/env python3
"""packaging/completion.py PROGRAM FOLDER [OWN_NAME...]

Writes the completions of the program for bash (FOLDER/haptometer) and zsh (FOLDER/_haptometer) from what
`PROGRAM --describe-options` says. All words stand in them: no key pressed starts the program. Each OWN_NAME is a verb
that is installed under its own name too.
"""
import dataclasses
import json
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
BEHIND_DASHES = {"session new": "acquire"}  # whose options stand behind --


@dataclasses.dataclass(frozen=True)
class Value:
    """What an option or a positional argument takes."""
    words: tuple = ()  # one that ends with '=' or ':' is only a beginning
    kind: str = ""  # "files" of these extensions (none: any), "behind" (files behind = or :), "folders", "ports"
    extensions: tuple = ()


def value_of(option):
    placeholder = option["placeholder"]
    found = re.findall(r"[A-Z]+\.([a-z0-9|]+)", placeholder)
    known = [word + "=" if "KEY=" in placeholder else word for word in option["known"]]
    # "recorded|max|FACTOR" has two words
    alternatives = placeholder.split("|") if "|" in placeholder and not found else []
    words = option["choices"] or known + [word for word in alternatives if re.fullmatch(r"[A-Z]?[a-z][a-z-]*", word)]
    if placeholder == "PORT":
        return Value(kind="ports")
    if placeholder == "DIR":
        return Value(kind="folders")
    kind = "behind" if "=" in placeholder or any(word.endswith(":") for word in words) else "files"
    if found and "SOCKET" not in placeholder:
        return Value(tuple(words), kind, tuple(found[0].split("|")))
    if re.search(r"FILE|PATH|DIR|SOCKET", placeholder) or any(word.endswith(":") for word in words):
        return Value(tuple(words), kind)
    return Value(tuple(words))


def value_of_positional(one):
    """The text of a positional argument names the files."""
    text = re.sub(r"\(docs/[^)]*\)|, docs/[^)]*", "", one["text"])
    if one["known"] or "key=" in text:
        return Value(tuple(one["known"]))
    kinds = {"bin": r"\.bin\b|Trials", "csv": r"\bCSV\b", "h5": r"\bHDF5\b"}
    extensions = [extension for extension, pattern in kinds.items() if re.search(pattern, text)]
    extensions = list(dict.fromkeys(extensions + re.findall(r"\.([a-z][a-z0-9]+)", text)))
    is_folder = re.search("folder", text, re.IGNORECASE) and not extensions
    return Value((), "folders" if is_folder else "files", tuple(extensions))


def quoted(text):
    """A word for a shell."""
    return "'" + text.replace("'", "'\\''") + "'"


def names(option):
    return option["name"].split(",")


class Commands:
    """The verbs and their parts: "" is the program, "trial info" a part."""

    def __init__(self, described):
        self.by_name = {one["name"]: one for one in described}
        self.verbs = [name for name in self.by_name if " " not in name]

    def below(self, name):
        """Verbs of the program, parts of a verb: name and first sentence."""
        length = len(name.split()) + 1
        return [(words[-1], re.split(r"\.(?: |$)", one["summary"])[0]) for one in self.by_name.values()
                if len(words := one["name"].split()) == length and words[:-1] == name.split()]

    def options(self, name):
        one = self.by_name[name]
        return one["options"] + [{**flag, "kind": "flag", "repeatable": False, "several": False, "optional": False}
                                 for flag in one["common"]]

    def with_several(self):
        """Options of several values at a time: "sweep --merge"."""
        return [f"{name} {each}" for name in self.by_name for option in self.options(name)
                if option["several"] for each in names(option)]


def filled_in(name, places):
    """The file beside this one, with what belongs in its places, such as @NAMES@."""
    return re.sub(r"@([A-Z]+)@", lambda found: places[found[1]], (HERE / name).read_text())


# --- bash ---


def bash_command(commands, name):
    """The case of a command."""
    said = {"parts": " ".join(word for word, _ in commands.below(name))}
    if not name:
        said["parts"] += " help"
        said["once"] = "-h|--help --version"
    elif commands.by_name[name]["options"] or " " in name:
        options = commands.options(name)
        said["once"] = " ".join("|".join(names(one)) for one in options if not one["repeatable"])
        said["again"] = " ".join(" ".join(names(one)) for one in options if one["repeatable"])
        positionals = commands.by_name[name]["positionals"]
        said["has_words"] = "" if not positionals else "many" if positionals[0]["repeatable"] else "one"
    else:
        said["once"] = "-h|--help"
    return f"    {quoted(name)}) " + " ".join(f"{key}={quoted(text)}" for key, text in said.items() if text) + " ;;"


def bash_values(commands):
    """The cases of what options take; those that take the same share one."""
    places = {}
    for name, one in commands.by_name.items():
        for option in one["options"]:
            if option["kind"] != "flag":
                places.setdefault(value_of(option), []).extend(f"{name} {each}" for each in names(option))
        for positional in one["positionals"][:1]:
            places.setdefault(value_of_positional(positional), []).append(name)
    for value, found in places.items():
        said = {"words": " ".join(value.words), "kind": value.kind, "extensions": " ".join(value.extensions)}
        text = " ".join(f"{key}={quoted(text)}" for key, text in said.items() if text)
        yield "    " + " | \\\n      ".join(map(quoted, found)) + f")\n      {text or ':'} ;;"


def bash(commands, own):
    behind = [f"{quoted(name + ' --')}) command={other} given=' ' option= ; continue ;;"
              for name, other in BEHIND_DASHES.items()]
    places = {
        "COMMANDS": "\n".join(bash_command(commands, name) for name in ["", *commands.by_name]),
        "VALUES": "\n".join(bash_values(commands)),
        "SEVERAL": " | ".join(map(quoted, commands.with_several())),
        "OWN": " | ".join(own) or "''",
        "BEHIND": "\n      ".join(behind),
        "NAMES": " ".join(["haptometer", *own]),
    }
    return filled_in("completion.bash.in", places)


# --- zsh ---


def zsh_action(value):
    """How _arguments finds the values."""
    pattern = "*"
    if value.extensions:
        pattern = "(#i)*." + (value.extensions[0] if len(value.extensions) == 1 else f"({'|'.join(value.extensions)})")
    if value.kind == "ports":
        return "_haptometer_ports"
    if value.kind == "folders":
        return "_files -/"
    if value.words or value.kind == "behind":
        words = map(quoted, [value.kind, pattern, *value.words])
        return "{_haptometer_words " + " ".join(words).replace(":", "\\:") + "}"
    return f"_files -g {quoted(pattern)}" if value.kind else " "


def zsh_text(text):
    return re.sub(r"([\\\[\]:])", r"\\\1", text)


def zsh_option(option):
    """An option for each of its names: '(-o --output)--output=[text]:FILE:action'."""
    for name in names(option):
        begin = "*" if option["repeatable"] else f"({' '.join(names(option))})"
        behind = ""
        if option["kind"] != "flag":
            name += "=" if name.startswith("--") else "+"
            message, action = zsh_text(option["placeholder"]), zsh_action(value_of(option))
            behind = f"{':' if option['optional'] else ''}:{message}:{action}"
        yield quoted(f"{begin}{name}[{zsh_text(option['text'])}]{behind}")


def zsh_positional(one):
    begin = "*" if one["repeatable"] else "" if one["required"] else ":"
    return quoted(f"{begin}:{zsh_text(one['name'])}:{zsh_action(value_of_positional(one))}")


def zsh_command(commands, name):
    if not name:
        specs = ["'(-)'{-h,--help}'[Show the verbs]'", "'(-)--version[Show the version]'"]
    else:
        specs = [spec for option in commands.options(name) for spec in zsh_option(option)]
        specs += map(zsh_positional, commands.by_name[name]["positionals"])
    return f"    {quoted(name)})\n      _arguments -S " + " \\\n        ".join(specs) + " ;;"


def zsh_below(commands, name):
    below = commands.below(name) + ([] if name else [("help", "Show the options of a verb")])
    described = (quoted(f"{word}:{summary}") for word, summary in below)
    return f"      {quoted(name)}) below=(" + "\n        ".join(described) + ") ;;"


def zsh(commands, own):
    behind = [f"{quoted(name)})\n      dashes=${{words[(i)--]}}\n      if (( dashes < CURRENT )); then\n"
              f"        words=({other} \"${{(@)words[dashes + 1,-1]}}\")\n        (( CURRENT -= dashes - 1 ))\n"
              f"        name={other}\n      fi ;;" for name, other in BEHIND_DASHES.items()]
    with_parts = ["", *(name for name in commands.verbs if commands.below(name))]
    places = {
        "COMMANDS": "\n".join(zsh_command(commands, name) for name in ["", *commands.by_name]),
        "BELOW": "\n".join(zsh_below(commands, name) for name in with_parts),
        "SEVERAL": " | ".join(map(quoted, commands.with_several())),
        "OWN": "|".join(own) or "''",
        "BEHIND": "\n    ".join(behind),
        "NAMES": " ".join(["haptometer", *own]),
    }
    return filled_in("completion.zsh.in", places)


def main():
    program, folder, *own = sys.argv[1:]
    said = subprocess.run([program, "--describe-options"], check=True, capture_output=True, text=True).stdout
    commands = Commands(json.loads(said))
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "haptometer").write_text(bash(commands, own))
    (folder / "_haptometer").write_text(zsh(commands, own))


if __name__ == "__main__":
    main()
