#!/usr/bin/env python3
"""Runs every command of README.md, CONTRIBUTING.md and docs/, each page in a temporary folder
with a link to fixtures/, in the order in which they stand. Each must end with status 0, or with the status that its
page states (REFUSED). Where the page shows what a command prints, it prints that: every line, with any number in
place of a number. A picture has the words of the one that the command in its text draws; --draw replaces it.

    tests/system/commands_of_pages_test.py [--times] [--draw] [PAGE ...]

A command is a line of a code block that begins with a program, perhaps behind `$ `, or that pipes into one, with the
lines that continue it; a block of shell (```sh) that uses a program is one command. Behind a command with `$ `, and
in a block of ```output behind one of shell, stands what it prints, shortened at `...`. `emulate` and `acquire
--daemon` run until the next of them, or until the page ends. Files and devices that a page supposes are in PREPARED,
EMULATED and CHANGED.
"""
import contextlib
import functools
import itertools
import math
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "tests/golden")]
from golden import impedance, tap  # noqa: E402
from programs import DEADLINE_S, Emulator, check, program, wait_for  # noqa: E402

PROGRAM = r"(?:haptometer|acquire|analyze|fit-lra)(?= |$)"
COMMAND = re.compile(rf"(?:\$ )?(?:\./|build/release/bin/)?((?:\S+ \| )?{PROGRAM}.*)")
FENCED = re.compile(r"^ *```(\w*)\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)
INDENTED = re.compile(r"(?<=\n\n)(?: {4,}\S.*\n+)+")
SERVER = re.compile(r"(haptometer emulate|acquire --daemon) (?!--help)")
NUMBER = re.compile(r"-?\d[\d.]*(?:\(\d+\))?(?:e[-+]?\d+)?")
# text of a picture that ends with the command that draws it, and the picture
DRAWN = re.compile(r"!\[[^\]]*\((\w[^()]*)\)\]\(([^)]+)\)")


class Command(NamedTuple):
    page: str
    line: int
    text: str
    shown: str = ""  # of its output


# --- what the pages need ---

DAQ, DAYS, STUDY, SESSION, CALIBRATION, ADAPTER, LABEL, WINDOWS = (f"docs/how-to/{name}.md" for name in (
    "record-with-a-daq", "record-for-days", "run-a-study", "run-a-session", "calibrate", "find-an-adapter",
    "mend-a-wrong-label", "windows"))


def block(page, language):
    """The first fenced block of a language on a page."""
    text = (ROOT / page).read_text(encoding="utf-8")
    found = [match[2] for match in FENCED.finditer(text) if match[1] == language]
    check(found, f"{page} has no block of {language} any more")
    return found[0]


def laser(amplitude_mm):
    """A table of a laser that states no units: 225 Hz at 10 kHz for 1 s, 1 um of noise."""
    draw, step = random.Random(4), 2 * math.pi * 225 / 1e4
    return "t;laser\n" + "".join(f"{n / 1e4:.4f};{amplitude_mm * math.sin(step * n) + draw.gauss(0, 1e-3):.5f}\n"
                                 for n in range(10000))


def drive_off():
    """Samples of a DAQ with the drive off: 1 mV of noise at 10 kHz for 3 s."""
    draw = random.Random(5)
    return "".join(f"{draw.gauss(0, 1e-3):.6f}\n" for _ in range(30000))


def pairs():
    """The pairs of the page on calibrations, measured once more with 0.3 mV of noise."""
    draw = random.Random(6)
    rows = [line.split(",") for line in block(CALIBRATION, "csv").splitlines()[1:]]
    return "displacement_mm,voltage_v\n" + "".join(f"{mm},{float(v) + draw.gauss(0, 3e-4):.4f}\n" for mm, v in rows)


def daq_table():
    """A DAQ's table of a laser's volts: 225 Hz at 10 kHz for 1 s."""
    return laser(0.28).replace("t;laser", "seconds;volts").replace(";", ",")


def daq_file():
    """A table of a DAQ that states its units: 225 Hz at 10 kHz for 1 s."""
    return laser(0.28).replace("t;laser", "time_s,displacement_mm").replace(";", ",")


def drives():
    """The table of study.md."""
    text = (ROOT / "docs/reference/study.md").read_text(encoding="utf-8")
    return re.search(r"^ +drive_v,rms_m\n(?: +[\d.e,-]+\n)+", text, re.MULTILINE)[0].replace(" ", "")


def two_of(fixture, name):
    """The command for two recordings of a fixture that differ by their last rows: copies are refused."""
    return f"for n in 1 2; do grep -v '^#' fixtures/{fixture}.csv | head -n -$n >{name}$n.csv; done"


PAIRS = {"pairs.csv": lambda: block(CALIBRATION, "csv"), "today.csv": pairs}
DAQ_FILES = {"il030.toml": lambda: block(DAQ, "toml"), "my_daq.py": lambda: block(DAQ, "python")}
RIG = {"trials": "mkdir trials", "rig.toml": lambda: block(DAYS, "toml").replace("/var/lib/haptometer", "trials")}
HEADS = {"/dev/haptometer/FT4ABCDE-00": ["--baud", "38400"],
         "192.168.1.20:5000": ["--protocol", "stream", "--tcp", "127.0.0.1:0"]}
TAP = {"tap.csv": lambda: tap(1, 214),
       "tap.bin": "cut -d, -f2 tap.csv |"
                  " acquire --sensor pipe --format text --rate 2kHz --channels displacement:m -o tap.bin"}
IMPEDANCE = {"z.csv": impedance}

# What a page's commands read and none of them makes, in order: the text that a function gives, or what a command makes.
PREPARED = {
    "README.md": {"trial.bin": "cp fixtures/recorded_trial.bin trial.bin", "mine.csv": lambda: laser(0.28),
                  "off.csv": lambda: laser(0)},
    "docs/how-to/bring-your-own-csv.md": {"mine.csv": lambda: laser(0.28)},
    ADAPTER: {"mine.toml": lambda: block(ADAPTER, "toml")},
    LABEL: {"trials": "mkdir trials; cp fixtures/recorded_trial.bin trials/FILE.bin"},
    WINDOWS: {"lab": "mkdir lab", "run.csv": daq_file},
    "docs/how-to/drop-test.md": {**TAP, "open": two_of("impulse", "open"), "load": two_of("impulse_33ohm", "loaded")},
    "docs/how-to/measure-impedance.md": IMPEDANCE,
    DAYS: RIG,
    DAQ: {**DAQ_FILES, "off.txt": drive_off,
          "off.bin": "acquire --sensor pipe --format text --rate 10kHz --channels displacement:V"
                     " --calibration il030.toml -o off.bin <off.txt"},
    SESSION: {"daq": "mkdir daq"},
    CALIBRATION: {**PAIRS, "steps.csv": lambda: block(CALIBRATION, "text"), "daq.csv": daq_table,
                  "my_daq.py": lambda: block(DAQ, "python")},
    "docs/reference/calibrate.md": PAIRS,
    STUDY: {"recorded": "mkdir recorded"},
    "docs/reference/campaign.md": {"slurm": "mkdir slurm; printf '#!/bin/sh\\necho 1\\n' >slurm/sbatch;"
                                            " chmod +x slurm/sbatch"},
    "docs/reference/analyze.md": {"trial.bin": "cp fixtures/recorded_trial.bin trial.bin",
                                  "trials": "mkdir trials; cp fixtures/recorded_trial.bin trials"},
    "docs/reference/daemon.md": RIG,
    "docs/reference/fit-adapter.md": TAP,
    "docs/reference/fit-impedance.md": IMPEDANCE,
    "docs/reference/sensors.md": DAQ_FILES,
    "docs/reference/session.md": {"DIR": "mkdir DIR"},
    "docs/reference/study.md": {"trials": block(STUDY, "sh"), "drive.csv": drives},
}

# Ports in the commands or prepared files of a page, and the options of the emulator whose port takes the place.
EMULATED = {
    "docs/reference/acquire.md": {"/dev/ttyUSB0": []},
    "docs/reference/daemon.md": HEADS,
    DAYS: HEADS,
    STUDY: {"/dev/ttyUSB0": ["--protocol", "stream"]},
    SESSION: {"/dev/ttyUSB0": ["--protocol", "stream", "--baud", "921600"]},
    WINDOWS: {"/dev/ttyUSB0": ["--protocol", "stream"]},
}


def at_terminal(command, keys):
    """The command at a terminal of its own, with keys that are typed there."""
    return f"({keys}) | TERM=xterm script -qec '{command}' /dev/null"


# Other texts in the commands of a page, what takes their place, and why.
CHANGED = {
    "docs/reference/acquire.md": [("--duration 10s", "--duration 1s", "a second shows as much")],
    "docs/reference/campaign.md": [("haptometer sweep", "PATH=$PWD/slurm:$PATH haptometer sweep",
                                    "a Slurm that takes every job"),
                                   ("haptometer campaign resume", "PATH=$PWD/slurm:$PATH haptometer campaign resume",
                                    "a Slurm that takes every job")],
    "docs/reference/sensors.md": [("my_daq |", "/usr/bin/python3 my_daq.py |", "the program of the page on DAQs")],
    CALIBRATION: [("my_daq |", "/usr/bin/python3 my_daq.py |", "the program of the page on DAQs")],
    DAQ: [("my_daq |", "/usr/bin/python3 my_daq.py |", "what the page puts in place of a DAQ")],
    SESSION: [("--duration 4s --expect", "--duration 1s --expect", "a second shows as much"),
              ("haptometer session run day1",
               at_terminal("haptometer session run day1", "sleep 2; printf ' '; sleep 3; printf q; sleep 1"),
               "it needs a terminal, and a key for a trial"),
              ("haptometer session run day2", at_terminal("haptometer session run day2", "sleep 1; printf q; sleep 1"),
               "it needs a terminal")],
    "docs/tutorial.md": [("haptometer session run pilot",
                          at_terminal("haptometer session run pilot", "sleep 2; printf ' '; sleep 4; printf q; sleep 1"),
                          "it needs a terminal, and a key for the trial")],
    LABEL: [("--file FILE", "--file $(ls day1/trials | grep attempt-1_condition-adapter | tail -1)",
             "FILE has the time in it")],
    WINDOWS: [("/mnt/c/lab", "lab", "Windows is not here"),
              ("haptometer session run day1",
               at_terminal("haptometer session run day1", "cp run.csv lab/1.csv; sleep 5; printf q; sleep 1"),
               "it needs a terminal, and a file of a program on Windows"),
              ("haptometer session next day1", "(sleep 1; cp run.csv lab/2.csv) & haptometer session next day1",
               "it waits for a file of a program on Windows")],
    STUDY: [("--duration 3s -o trials/", "--duration 1s -o recorded/", "the study is that of the simulated trials"),
            ("trials/FILE.bin", "trials/*adapter_repeat-1_subject-4.bin", "FILE has the time in it")],
}

# The beginning of a command that a page shows refused, its status, and what the page says.
REFUSED = {
    "README.md": [("haptometer trial info mine.csv", 3, "what it does not state")],
    "docs/how-to/bring-your-own-csv.md": [("haptometer trial info mine.csv", 3, "the answer has status 3")],
    "docs/how-to/noise-floor.md": [("analyze off.bin", 3, "with status 3")],
    STUDY: [("haptometer study compare", 3, "The exit status is 3")],
    "docs/reference/study.md": [("haptometer study compare", 3, "Status 3: the mean of a condition differs")],
    "docs/reference/analyze.md": [("analyze trial.bin --expect", 3, "the exit status is 3")],
}


# --- commands of a page ---

def blocks(text):
    """(number of the first line, language, lines) of each block of code."""
    found = [(match.start(2), match[1], match[2]) for match in FENCED.finditer(text)]
    blank = FENCED.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), text)
    found += [(match.start(), "", match[0]) for match in INDENTED.finditer(blank)]
    return [(text.count("\n", 0, at) + 1, language, code.splitlines()) for at, language, code in sorted(found)]


def commands_of(page, text):
    found = []
    for first, language, lines in blocks(text):
        if language == "sh" and any(COMMAND.match(line.strip()) for line in lines):
            found.append(Command(page, first, "\n".join(lines)))
        if language == "output":
            found[-1] = found[-1]._replace(shown="\n".join(lines))
        if language in ("sh", "output"):
            continue
        for number, line in enumerate(lines):
            command = COMMAND.fullmatch(line.strip())
            last = number
            while lines[last].endswith("\\") and last + 1 < len(lines):
                last += 1
            if command:
                output = shown_behind(lines[last + 1:]) if line.lstrip().startswith("$ ") else ""
                found.append(Command(page, first + number, "\n".join([command[1], *lines[number + 1:last + 1]]), output))
    return found


def shown_behind(lines):
    """The output that a block shows behind a command: as far as the next one."""
    return "\n".join(itertools.takewhile(lambda line: not line.lstrip().startswith("$ "), lines)).strip()


def masked(text):
    """A text without its numbers and the widths of its blanks."""
    return "".join(" ".join(NUMBER.sub("0", line).split()) + "\n" for line in text.strip().splitlines())


def is_shown(shown, output):
    """Whether an output is what a page shows of it, without what a slow build says of its work."""
    output = "\n".join(line for line in output.splitlines() if "; Ctrl-C ends it" not in line)
    lines = ["(?:.*\n)*?" if line == "..." else re.escape(line).replace(r"\.\.\.", ".*") + "\n"
             for line in masked(shown).splitlines()]
    return re.fullmatch("".join(lines), masked(output)) is not None


def words_of(picture):
    """The texts of an SVG that have a letter; of another picture its size in the PNG header."""
    if picture.suffix != ".svg":
        return picture.read_bytes()[16:24]
    texts = re.findall(r">([^<>]*[A-Za-z][^<>]*)<", picture.read_text(encoding="utf-8"))
    return [masked(text) for text in texts]


def pages():
    """The commands of each page that has some."""
    paths = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
    names = [str(path.relative_to(ROOT)) for path in paths]
    found = {name: list(commands_of(name, path.read_text(encoding="utf-8"))) for name, path in zip(names, paths)}
    return {name: commands for name, commands in found.items() if commands}


def check_search():
    """Commands are found where they stand, with their continuation, and prose is none."""
    text = ("analyze a\n\n1. Do:\n\n       $ analyze a \\\n         b\n       a: 1 um\n\n   analyze c\n\n"
            "```sh\nfor f in a; do\n  analyze $f\ndone\n```\n\n    x | acquire d\n    acquire: e\n")
    found = [(command.line, command.text) for command in commands_of("p", text)]
    check(is_shown("a: 1.0 um\n...\nb ... c\n", "a:  23(1) um\n\nx\nb 1 c"), "an output is not recognised")
    check(not is_shown("a: 1 um\nb", "a: 1 um\nx\nb") and not is_shown("a: 1 um", "a: 1 mm"), "any output is taken")
    wanted = [(5, "analyze a \\\n         b"), (12, "for f in a; do\n  analyze $f\ndone"), (17, "x | acquire d")]
    check(found == wanted, found)


def check_tables(found):
    """What the tables name has commands, and is refused where the page says it."""
    for page in {*PREPARED, *EMULATED, *CHANGED, *REFUSED}:
        check(page in found, f"{page} has no command any more")
    for page, refused in REFUSED.items():
        text = (ROOT / page).read_text(encoding="utf-8")
        for beginning, _, statement in refused:
            check(any(command.text.startswith(beginning) for command in found[page]), f"{page} has no '{beginning}'")
            check(statement in text, f"{page} does not say '{statement}' any more")


# --- running them ---

class Folder:
    """A temporary folder in which the commands of one page run, with the programs of the build on the path."""

    def __init__(self, page, path, changes):
        self.page, self.path, self.changes = page, pathlib.Path(path), changes
        self.used, self.server, self.groups = set(), None, []
        self.environment = {**os.environ, "PATH": os.path.dirname(program("haptometer")) + ":" + os.environ["PATH"],
                            "XDG_RUNTIME_DIR": path}
        os.symlink(ROOT / "fixtures", self.path / "fixtures")

    def changed(self, text):
        """A text of the page as it is run here."""
        for old, new in self.changes.items():
            if old in text:
                self.used.add(old)
                text = text.replace(old, new)
        return text

    def start(self, text, **streams):
        """A shell in a session of its own, so that all of it can be ended."""
        return subprocess.Popen(["sh", "-ec", text], cwd=self.path, env=self.environment, stdin=subprocess.DEVNULL,
                                start_new_session=True, **streams)

    def run(self, text):
        """Exit status and output of a command that ends by itself; what it left running ends with the page."""
        with tempfile.TemporaryFile() as file:
            process = self.start(text, stdout=file, stderr=subprocess.STDOUT)
            self.groups.append(process.pid)
            late = ""
            try:
                process.wait(DEADLINE_S)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
                late = f"is not done after {DEADLINE_S} s"
            file.seek(0)
            return process.returncode, file.read().decode(errors="replace") + late

    def end_all(self):
        """The server, and what the commands left running."""
        self.end_server()
        for group in self.groups:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(group, signal.SIGTERM)

    def serve(self, text):
        """Begins a command that runs until it is ended; 0 once it answers, else its exit status, and what it said."""
        self.end_server()
        log = self.path / "server.log"
        with open(log, "w", encoding="utf-8") as file:
            self.server = self.start("exec " + text.rstrip("& "), stdout=file, stderr=file)
        ready = functools.partial(self.is_ready, text, log)
        wait_for(f"{self.page}: readiness of '{text}'", lambda: self.server.poll() is not None or ready())
        status = 0
        if not ready():
            status, self.server = self.server.poll() or "no readiness", None
        return status, log.read_text()

    def is_ready(self, text, log):
        """An emulator says so; all sensors of a daemon record."""
        if "--daemon" not in text:
            return "ready " in log.read_text()
        asked = text.partition("#")[0].replace("--daemon", "--status")
        return self.run(rf"{asked} | grep -q ': \([0-9]*\) of \1 recording'")[0] == 0

    def end_server(self):
        """By SIGTERM, after which a daemon has status 0; an emulator may have come to the end of its duration."""
        server, self.server = self.server, None
        if not server:
            return
        server.terminate()
        try:
            status = server.wait(DEADLINE_S)
        except subprocess.TimeoutExpired:
            os.killpg(server.pid, signal.SIGKILL)
            status = server.wait()
        text = server.args[-1]
        check(status in ((0,) if "--daemon" in text else (0, 143)), f"{self.page}: {text} ends with {status}")

    def prepare(self, files):
        for name, maker in files.items():
            if callable(maker):
                (self.path / name).write_text(self.changed(maker()), encoding="utf-8")
            else:
                status, said = self.run(maker)
                check(status == 0, f"{self.page}: {name} is not made: status {status}: {said}")

    def failure(self, command):
        """What is wrong with a command's end, or None."""
        text = self.changed(command.text)
        refused = [status for beginning, status, _ in REFUSED.get(self.page, []) if command.text.startswith(beginning)]
        wanted = refused[0] if refused else 0
        begin = time.monotonic()
        status, said = self.serve(text) if SERVER.match(text) else self.run(text)
        if "--times" in sys.argv:
            print(f"{time.monotonic() - begin:6.2f} s  {command.page}:{command.line}: {text}")
        if status != wanted:
            return f"{command.page}:{command.line}: {text}\n  ends with {status} in place of {wanted}: {said.strip()}"
        if command.shown and not is_shown(command.shown, said):
            return f"{command.page}:{command.line}: {text}\n  prints something else:\n{said.rstrip()}"
        return None

    def failure_of_picture(self, command, path):
        """What is wrong with a picture of the page, which the command draws as docs/NAME; or None."""
        (self.path / "docs").mkdir(exist_ok=True)
        status, said = self.run(command)
        drawn, wanted = self.path / "docs" / os.path.basename(path), (ROOT / self.page).parent / path
        if status != 0 or not drawn.exists() or not wanted.exists() and "--draw" not in sys.argv:
            return f"{self.page}: {command} does not draw {drawn.name}: {said.strip()}"
        if "--draw" in sys.argv:
            shutil.copy(drawn, wanted)
        if words_of(drawn) != words_of(wanted):
            return f"{self.page}: {path} is another picture: {words_of(drawn)} in place of {words_of(wanted)}"
        return None


def changes_of(page, stack):
    """What takes the place of which text; the emulators end with the stack."""
    emulated = EMULATED.get(page, {})
    ports = {text: stack.enter_context(Emulator(*options)).port for text, options in emulated.items()}
    return {**ports, **{old: new for old, new, _ in CHANGED.get(page, [])}}


def failures_of(page, commands):
    """Runs a page's commands; a text for each that fails."""
    with contextlib.ExitStack() as stack:
        path = stack.enter_context(tempfile.TemporaryDirectory())
        folder = Folder(page, path, changes_of(page, stack))
        stack.callback(folder.end_all)
        folder.prepare(PREPARED.get(page, {}))
        drawn = DRAWN.findall((ROOT / page).read_text(encoding="utf-8"))
        failures = [folder.failure(command) for command in commands]
        failures += [folder.failure_of_picture(command, picture) for command, picture in drawn]
        failures = [failure for failure in failures if failure]
        unused = set(folder.changes) - folder.used
        return failures + [f"{page}: '{text}', which is to be changed, stands in no command" for text in unused]


def main():
    check_search()
    found = pages()
    check_tables(found)
    chosen = [word for word in sys.argv[1:] if not word.startswith("--")] or list(found)
    failures = [failure for page in chosen for failure in failures_of(page, found[page])]
    print("".join(failure + "\n" for failure in failures), end="")
    count = sum(len(found[page]) for page in chosen)
    check(chosen != list(found) or count > 70, f"{count} commands found")
    check(not failures, f"{len(failures)} failures in {count} commands")
    print(f"{count} commands of {len(chosen)} pages")


if __name__ == "__main__":
    main()
