"""The pinned commands (tests/golden/commands.toml) called within Python and as processes: the same JSON."""
import json
import os
import pathlib
import shlex
import sys
import tomllib

import haptometer as hm
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
os.environ.setdefault("HAPTOMETER_PROGRAMS", str(ROOT / "build/release/bin"))
sys.path.insert(0, str(ROOT / "tests/golden"))
import golden  # noqa: E402

TABLE = tomllib.loads((golden.FOLDER / "commands.toml").read_text())
# what writes a file would find that of the other call there
COMMANDS = [command for command in TABLE["command"] if "files" not in command and "each" not in command
            and command["run"].split()[0] not in ("acquire", "emulate", "session") and "--json" in command["run"]
            and not {"-o", "--output", "--save", "--resume"} & set(shlex.split(command["run"]))]


def without_run(text):
    """A document without its time and measured seconds, or a text as it is."""
    if not text.startswith("{"):
        return text
    document = json.loads(text)
    document.get("provenance", {}).pop("utc", None)
    return document


def same(ours, theirs, path=""):
    """Whether two documents are equal but for what is measured in seconds of this machine."""
    if isinstance(ours, dict) and isinstance(theirs, dict):
        return ours.keys() == theirs.keys() and all(
            same(ours[key], theirs[key], key) for key in ours if not key.startswith(("measured", "took", "seconds", "predicted")))
    if isinstance(ours, list) and isinstance(theirs, list):
        return len(ours) == len(theirs) and all(map(same, ours, theirs))
    return ours == theirs


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("golden")
    before = os.getcwd()
    os.chdir(folder)
    os.symlink(ROOT / "fixtures", "fixtures")
    yield golden.Inputs(TABLE)
    os.chdir(before)


def test_there_are_commands_of_every_verb():
    """cost, plan_drop_test, study_compare and sweep are in test_verbs.py."""
    verbs = {command["run"].split()[0] for command in COMMANDS}
    assert verbs == {"analyze", "calibrate", "compare", "fit-lra", "fit-skin", "reproduce", "simulate", "study", "trial", "tune"}
    # older names of verbs
    for option in ("--impedance", "--adapter", "--plan"):
        assert any(option in command["run"] for command in COMMANDS)
    assert len(COMMANDS) > 100


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command["name"])
def test_same_document(command, inputs):
    words = shlex.split(command["run"])
    inputs.want(words)
    theirs = golden.execute(words)
    ours = hm._native.call(words, False)
    assert ours.status == theirs.returncode, ours.errors
    assert same(without_run(ours.json), without_run(theirs.stdout.decode()))
