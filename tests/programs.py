"""Runs the programs of a build, for the tests written in Python; it knows nothing of what they send.

The build is the directory that HAPTOMETER_PROGRAMS names. Use:
  sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
  from programs import check, run
"""
import csv
import io
import json
import os
import re
import subprocess
import sys
import time

DEADLINE_S = 240  # what takes 25 s under the sanitizers may have a quarter of a core
SCENE = "fixtures/lra_adapter.toml"


def program(name):
    """The path of a program of the build."""
    return os.path.abspath(
        os.path.join(os.environ.get("HAPTOMETER_PROGRAMS", "build/release/bin"), name))


def check(condition, text):
    if not condition:
        sys.exit("FAILED: " + str(text))


def skip(text):
    """Ends with the status that stands for a test that was not tried."""
    print("skipped:", text)
    sys.exit(77)


def wait_for(what, condition):
    """The first true value of `condition`, within the deadline."""
    deadline = time.monotonic() + DEADLINE_S
    while time.monotonic() < deadline:
        value = condition()
        if value:
            return value
        time.sleep(0.02)
    sys.exit(f"FAILED: {what} does not come within {DEADLINE_S} s")


def run(*words, status=0, data=b"", env=None):
    """Runs `haptometer WORDS`, which must end with `status`; its output is text."""
    done = subprocess.run([program("haptometer"), *words], input=data, capture_output=True, env=env,
                          timeout=DEADLINE_S)
    done.stdout, done.stderr = done.stdout.decode(), done.stderr.decode()
    check(done.returncode == status, f"{words} ends with {done.returncode}: {done.stderr}")
    return done


def info(path):
    """`trial info --json`."""
    return json.loads(run("trial", "info", path, "--json").stdout)


def rows(path):
    """The rows of a trial, as dictionaries of the exported columns' texts."""
    lines = run("trial", "export", path).stdout.splitlines()
    table = "\n".join(line for line in lines if line and not line.startswith("#"))
    return list(csv.DictReader(io.StringIO(table)))


def trial_reader():
    """The function read_trial of docs/reference/formats.md, as it stands there."""
    namespace = {}
    with open("docs/reference/formats.md", encoding="utf-8") as file:
        code = re.search(r"```python\n(import json.*?)```", file.read(), re.S).group(1)
    exec(code, namespace)
    return namespace["read_trial"]


class Emulator:
    """A running `haptometer emulate` of the scene; `port` is the one that it names."""

    def __init__(self, *options):
        self.process = subprocess.Popen([program("haptometer"), "emulate", "--scene", SCENE, *options],
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        first = self.process.stdout.readline()
        if not first.startswith("ready "):
            self.process.kill()
            sys.exit(f"FAILED: first line {first!r}: {self.process.communicate()[1]}")
        self.port = first.split()[1]

    def end(self):
        """SIGTERM: status 143. Returns what it said on stderr."""
        self.process.terminate()
        said = self.process.communicate(timeout=DEADLINE_S)[1]
        check(self.process.returncode == 143, f"SIGTERM ends it with {self.process.returncode}: {said}")
        return said

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()
