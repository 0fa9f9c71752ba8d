"""The help of every verb has no word that the glossary lists as not to be used (docs/explanation/glossary.md)."""
import os
import re
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.join(HERE, ".."), os.path.join(HERE, "..", "architecture")]
from programs import check, run
from words import message, pattern_of, uses, words_not_to_use

HELP = {"haptometer": run("--help").stdout}


def add(*verb):
    HELP[" ".join(verb)] = run(*verb, "--help-all").stdout


verbs = re.findall(r"^  ([a-z][a-z-]+) ", HELP["haptometer"], re.MULTILINE)
for verb in verbs:
    add(verb)
for verb, kind in [("trial", kind) for kind in ("exclude", "export", "include", "info", "label", "plot")] + [
        ("study", kind) for kind in ("compare", "linearity", "matching")] + [
        ("session", kind) for kind in ("floor", "new", "next", "note", "redo", "reject", "relabel", "run", "skip", "status")]:
    add(verb, kind)
check(len(verbs) > 10, f"{len(verbs)} verbs")

pattern = pattern_of(words_not_to_use())
wrong = []
for verb, text in HELP.items():
    check(len(text.splitlines()) > 10, f"{verb}: {text}")
    lines = message(text).splitlines()
    wrong += [f"{verb}: '{word}' in: {text.splitlines()[line - 1].strip()}" for line, word in
              uses("\n".join(lines), pattern)]
check(not wrong, "words in help that the glossary replaces:\n" + "\n".join(wrong))
