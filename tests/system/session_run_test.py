"""`session run` at a pseudo terminal, and sessions whose trials come from another program's folder.

  tests/system/session_run_test.py keys|device|ending|folder|disk
  tests/system/session_run_test.py kills N
"""
import contextlib
import csv
import hashlib
import io
import json
import os
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

import numpy

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import DEADLINE_S, SCENE, Emulator, check, info, program, run, skip, wait_for
from terminal import Terminal

SCENE_SOURCE = ["--", "--sensor", f"scene:{SCENE}", "--speed", "max"]


def status(folder):
    return json.loads(run("session", "status", folder, "--json").stdout)


def log(folder):
    with open(f"{folder}/log.csv", encoding="utf-8", newline="") as file:
        return list(csv.DictReader(io.StringIO(file.read())))


def ended(folder, cell):
    """The last end of the cell (subject, condition, repeat) in the log."""
    return [line for line in log(folder) if line["event"] == "end"
            and (line["subject"], line["condition"], line["repeat"]) == cell][-1]


def name_of(cell):
    return f"subject {cell['subject']}, {cell['condition']}, repeat {cell['repeat']}"


def new(folder, *words, source=()):
    run("session", "new", folder, *words, *source)
    return folder


# --- keys ---

def record(terminal, key, verdict="GOOD", cell=""):
    """Strikes a key and waits for the verdict of the recording that it begins."""
    bells = len(terminal.bells)
    terminal.type(key)
    while len(terminal.bells) < bells + 2:
        before = time.monotonic()
        terminal.read(1)
        check(time.monotonic() - before < DEADLINE_S, "a bell at begin and end")
    terminal.wait_for(rf"{verdict} +{cell}[^\n]*(?s:.)*")
    terminal.wait_for(": ready")


def keys(directory):
    """Every key does what its verb does, in the order of the plan; the terminal is as it was before."""
    folder = new(f"{directory}/keys", "--subjects", "2", "--conditions", "stock,cone", "--order", "given",
                 "--duration", "1s", "--floor", "per-subject", source=SCENE_SOURCE)
    with Terminal("session", "run", folder) as terminal:
        terminal.wait_for("cell 1 of 6 +subject 1, floor +attempt 1")
        # of the scene the drive is on
        record(terminal, " ", "BAD", "subject 1, floor")
        terminal.wait_for("a drive is on\n +it comes again next; s skips it")
        terminal.wait_for("cell 1 of 6 +subject 1, floor +attempt 2")
        terminal.type("sno switch\r")
        terminal.wait_for("skipped: subject 1, floor")
        terminal.wait_for("cell 2 of 6 +subject 1, stock")
        record(terminal, "\r", "GOOD", "subject 1, stock, repeat 1")
        record(terminal, "r", "GOOD", "subject 1, stock, repeat 1")
        check(log(folder)[-1]["attempt"] == "2", "redo is a new attempt")
        # arrows and other keys without a use do nothing; Esc leaves a question
        terminal.type("\x1b[A\x1bOPyz\t")
        terminal.type("x")
        terminal.wait_for("rejected, because: _")
        terminal.type("\x1b")
        terminal.wait_for("SPACE record")
        terminal.type("x\r")
        terminal.type("finger slipteed\x7f\x7f\x7f\x7fped \u00fc\u00e9\x7f\x7fd\r")
        terminal.wait_for("rejected: subject 1, stock, repeat 1, attempt 2")
        check(log(folder)[-1]["reason"] == "finger slipped d", log(folder)[-1])
        terminal.wait_for("BAD +subject 1, stock, repeat 1(?s:.)*rejected: finger slipped d")
        check(status(folder)["bad"] == 1, status(folder))
        terminal.type("awrong key\r")
        terminal.wait_for("accepted: subject 1, stock, repeat 1, attempt 2")
        terminal.wait_for("GOOD +subject 1, stock, repeat 1")
        check(status(folder)["bad"] == 0 and status(folder)["good"] == 1, status(folder))
        terminal.type("xslipped\r")
        terminal.wait_for("BAD +subject 1, stock, repeat 1(?s:.)*rejected: slipped")
        record(terminal, "r", "GOOD", "subject 1, stock, repeat 1")
        terminal.type("nsubject speaks, quits\r")
        terminal.wait_for("of subject 1, stock, repeat 1")
        check((log(folder)[-1]["event"], log(folder)[-1]["reason"]) == ("note", "subject speaks, quits"), log(folder)[-1])
        # the next is recorded under the wrong label; mended, and undone
        terminal.type("l\rcone\r\rwas the cone\r")
        terminal.wait_for("is now subject 1, cone, repeat 1")
        terminal.wait_for("GOOD +subject 1, cone, repeat 1")
        check(status(folder)["bad"] == 1, "its own cell has the rejected attempt alone")
        terminal.type("l\rstock\r\rwas not\r")
        terminal.wait_for("is now subject 1, stock, repeat 1")
        # what is not in the plan is refused when it is typed
        terminal.type("l9\r")
        terminal.wait_for("subject \\(empty: as it is\\): 9_(?s:.)*9 is not in the plan")
        terminal.type("\x7f1\rcane\r")
        terminal.wait_for("cane is not in the plan")
        terminal.type("\x7f" * 4 + "cone\r2\r")
        terminal.wait_for("2 is not in the plan")
        terminal.type("\x1b")
        terminal.wait_for("SPACE record")
        terminal.type("l\r--floor\rno drive\r")
        terminal.wait_for("is now subject 1, floor: BAD \\(relabelled: no drive; a drive is on\\)")
        terminal.type("l\rstock\r\rit had one\r")
        terminal.wait_for("is now subject 1, stock, repeat 1: GOOD")
        # an attempt was of the floor, so that one is not skipped any more
        terminal.type("sstill none\r")
        terminal.wait_for("cell 3 of 6 +subject 1, cone")
        terminal.type("scone is broken\r")
        terminal.wait_for("skipped: subject 1, cone, repeat 1")
        terminal.wait_for("cell 4 of 6 +subject 2, floor")
        record(terminal, "f", "BAD", "subject 2, floor")
        terminal.type("sno switch\r")
        terminal.wait_for("skipped: subject 2, floor")
        record(terminal, " ", "GOOD", "subject 2, stock, repeat 1")
        record(terminal, " ", "GOOD", "subject 2, cone, repeat 1")
        terminal.type("q")
        check(terminal.end() == 0, terminal.text)
        terminal.check_restored()
    counts = status(folder)
    check([counts[key] for key in ("planned", "done", "good", "bad")] == [4, 3, 3, 0], counts)
    check(counts["next"]["is_floor"], counts["next"])
    headers = [info(f"{folder}/trials/{name}") for name in os.listdir(f"{folder}/trials")]
    for header in headers:
        check(header["fields"]["session.attempt"], header)


def verdict_in_time(directory):
    """The verdict on the screen after the end of a trial of 4 s: its time is printed, for it depends on the machine."""
    with Emulator("--protocol", "stream", "--baud", "921600", "--link", f"{directory}/port") as emulator:
        folder = new(f"{directory}/time", "--subjects", "1", "--conditions", "a", "--duration", "4s", "--repeats", "3",
                     "--expect", "tone=230Hz+-1Hz", source=["--", "--sensor", "stream", "--port", emulator.port])
        with Terminal("session", "run", folder) as terminal:
            terminal.wait_for(r"mm  20-500 Hz: \d+(\.\d+)? um RMS, 22\d\.\d+ Hz")
            took_s = []
            for repeat in range(1, 4):
                bells = len(terminal.bells)
                terminal.type(" ")
                terminal.wait_for("RECORDING +[1-3]")
                terminal.wait_for(r"20-500 Hz: \d+(\.\d+)? um RMS, 22\d\.\d+ Hz")
                # a key that is struck twice begins nothing
                terminal.type("  ")
                terminal.wait_for(rf"CHECK  subject 1, a, repeat {repeat} ")
                took_s.append(terminal.screen_at - terminal.bells[bells] - 4)
            terminal.wait_for("230 Hz \\+- 1 Hz is expected")
            terminal.type("q")
            check(terminal.end() == 0, terminal.text)
        print("verdicts after", ", ".join(f"{seconds:.3f} s" for seconds in took_s))
        check(len([line for line in log(folder) if line["event"] == "begin"]) == 3, log(folder))


# --- the device goes and comes back ---

def device(directory, away_s=3):
    """Lost while idle and in a recording: the screen states it, the cell stays, and it continues at that cell."""
    words = ["--protocol", "stream", "--baud", "921600", "--link", f"{directory}/port"]
    folder = f"{directory}/device"
    emulator = Emulator(*words)
    new(folder, "--subjects", "1", "--conditions", "a,b,c", "--order", "given", "--duration", "3s",
        source=["--", "--sensor", "stream", "--port", emulator.port])
    emulator.end()
    with Terminal("session", "run", folder) as terminal:
        # not there at the beginning
        terminal.wait_for("WAITING for it")
        terminal.type(" ")
        terminal.wait_for("the device is not there")
        emulator = Emulator(*words)
        terminal.wait_for(": ready")
        check("is not there" not in terminal.screen, terminal.screen)
        terminal.type(" ")
        terminal.wait_for("GOOD +subject 1, a, repeat 1")
        terminal.wait_for(": ready")
        terminal.type(" ")
        terminal.wait_for("RECORDING +1")
        emulator.end()
        terminal.wait_for("BAD +subject 1, b, repeat 1")
        terminal.wait_for("WAITING for it")
        terminal.wait_for("the connection was lost")
        terminal.wait_for("subject 1, b, repeat 1 +attempt 2")
        time.sleep(away_s)
        # decisions are possible meanwhile
        terminal.type("ncable\r")
        terminal.wait_for("of subject 1, b, repeat 1")
        emulator = Emulator(*words)
        terminal.wait_for(": ready")
        terminal.type(" ")
        terminal.wait_for("GOOD +subject 1, b, repeat 1")
        terminal.wait_for("subject 1, c, repeat 1 +attempt 1")
        # lost while nothing is recorded; q ends the waiting
        emulator.end()
        terminal.wait_for("WAITING for it")
        began = time.monotonic()
        terminal.type("q")
        check(terminal.end() == 0, terminal.text)
        check(time.monotonic() - began < 5, "q interrupts the waiting")
        terminal.check_restored()
    check(status(folder)["good"] == 2 and status(folder)["next"]["condition"] == "c", status(folder))
    check(len(os.listdir(f"{folder}/trials")) == 3, "all attempts are kept")


# --- how it ends ---

def refused_plans(directory):
    """What `new` can find out is refused in one line, and nothing is made."""
    plan = ["--subjects", "1", "--conditions", "a", "--duration", "1s"]
    for words, expected, part in (([*plan, "--", "--sensor", "scene:none.toml"], 3, "none.toml"),
                                  ([*plan, "--", "--sensor", "replay", "--port", SCENE], 3, "is not a trial"),
                                  ([*plan, "--port", "/dev/ttyUSB0"], 2, "write the source behind it"),
                                  (plan, 2, "-- --port /dev/ttyUSB0")):
        said = run("session", "new", f"{directory}/refused", *words, status=expected).stderr
        check(said.count("\n") == 1 and part in said, said)
        check(not os.path.exists(f"{directory}/refused"), words)


def ending(directory):
    """Without a terminal, a second one, Ctrl-C, SIGTERM twice, a closed terminal, an abort, a small window."""
    folder = new(f"{directory}/ending", "--subjects", "1", "--conditions", "a", "--duration", "20s", "--repeats", "9",
                 source=["--", "--sensor", f"scene:{SCENE}"])
    said = run("session", "run", folder, status=2).stderr
    check(said.count("\n") == 1 and "session next" in said, said)
    with Terminal("session", "run", folder, env={"TERM": "dumb"}) as terminal:
        check(terminal.end() == 2, terminal.text)
    with Terminal("session", "run", folder) as terminal:
        terminal.wait_for(": ready")
        refused = run("session", "next", folder, status=1).stderr
        holder = re.search(r"process (\d+) \(haptometer session run", refused)
        check(holder and int(holder[1]) == terminal.pid, refused)
        terminal.resize(30, 6)
        terminal.wait_for("session")
        check_fits(terminal, 30, 6)
        terminal.resize(7, 2)
        check_fits(terminal, 7, 2)
        terminal.resize(100, 30)
        terminal.wait_for("SPACE record")
        terminal.type("\x03")
        check(terminal.end() == 130, terminal.text)
        terminal.check_restored()
    for number, expected in ((signal.SIGTERM, 143), (signal.SIGINT, 130), (signal.SIGHUP, 129)):
        with Terminal("session", "run", folder) as terminal:
            terminal.wait_for(": ready")
            terminal.type(" ")
            terminal.wait_for("RECORDING")
            # twice: the second one does not leave the terminal as it is
            terminal.kill(number)
            terminal.kill(number)
            check(terminal.end() == expected, terminal.text)
            terminal.check_restored()
        check("stopped before its end" in log(folder)[-1]["reason"], log(folder)[-1])
    with Terminal("session", "run", folder) as terminal:
        terminal.wait_for(": ready")
        terminal.kill(signal.SIGABRT)
        check(terminal.end() == -signal.SIGABRT, terminal.status)
        terminal.check_restored()
    with Terminal("session", "run", folder) as terminal:
        terminal.wait_for(": ready")
        terminal.type(" ")
        terminal.wait_for("RECORDING")
        os.close(terminal.slave)
        os.close(terminal.master)
        wait_for("the end", lambda: os.waitpid(terminal.pid, os.WNOHANG)[0])
        terminal.status = 0
    check(log(folder)[-1]["event"] == "end" and "stopped" in log(folder)[-1]["reason"], log(folder)[-1])
    hanging_port(directory)
    # q stops a recording, and its cell comes again
    with Terminal("session", "run", folder) as terminal:
        terminal.wait_for(": ready")
        # those that were stopped before were of the same cell
        found = terminal.wait_for("(subject 1, a, repeat 1) +attempt (\\d+)")
        cell, attempt = found[1], int(found[2])
        terminal.type(" ")
        terminal.wait_for("RECORDING")
        terminal.type("q")
        terminal.wait_for(f"BAD +{cell}")
        terminal.wait_for("it comes again next")
        terminal.wait_for(f"{cell} +attempt {attempt + 1}")
        check(name_of(status(folder)["next"]) == cell, "and so it does in scripts")
        terminal.type("q")
        check(terminal.end() == 0, terminal.text)
    check(name_of(status(folder)["next"]) == cell, "also when it is left")


# asks the kernel itself: a sanitizer asks for the time before anything can be looked up
CLOCK = r"""
#include <stdlib.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>
extern "C" int clock_gettime(clockid_t clock, struct timespec* time) noexcept {
  const long status = syscall(SYS_clock_gettime, clock, time);
  const char* offset_s = environ != nullptr ? getenv("CLOCK_OFFSET_S") : nullptr;
  if (clock == CLOCK_REALTIME && offset_s != nullptr) time->tv_sec += atoi(offset_s);
  return static_cast<int>(status);
}
"""


def clock_set_back(directory):
    """By an hour between two trials: the order of the lines decides, and no file is written over."""
    shim = f"{directory}/clock.so"
    subprocess.run(["g++", "-shared", "-fPIC", "-D_GNU_SOURCE", "-x", "c++", "-o", shim, "-"], input=CLOCK, text=True,
                   check=True)
    folder = new(f"{directory}/clock", "--subjects", "1", "--conditions", "a,b,c", "--order", "given", "--duration",
                 "1s", source=SCENE_SOURCE)
    recorded = []
    for word, offset_s in (("next", 0), ("redo", -3600), ("next", -3600), ("redo", -7200), ("next", 0)):
        done = subprocess.run([program("haptometer"), "session", word, folder, "--json"], capture_output=True, check=True,
                              env={**os.environ, "LD_PRELOAD": shim, "CLOCK_OFFSET_S": str(offset_s)})
        outcome = json.loads(done.stdout)
        recorded.append((outcome["condition"], outcome["attempt"]))
    check(recorded == [("a", 1), ("a", 2), ("b", 1), ("b", 2), ("c", 1)], recorded)
    times = [line["utc"] for line in log(folder)]
    check(times != sorted(times), "the clock was set back")
    check(len(os.listdir(f"{folder}/trials")) == 5 and status(folder)["next"] is None, status(folder))
    # of each cell the attempt counts that came last, not the one with the latest time
    counted = [attempt["attempt"] for attempt in status(folder)["attempts"]
               if "excluded" not in info(f"{folder}/trials/{attempt['file']}")["fields"]]
    check(counted == [2, 2, 1], counted)


def hanging_port(directory):
    """A port whose opening hangs: q leaves all the same, and nothing is asked of a device while it is waited for."""
    with contextlib.ExitStack() as stack:
        server = stack.enter_context(socket.socket())
        server.bind(("127.0.0.1", 0))
        server.listen(0)
        # a full queue takes no further connection, and refuses none
        for _ in range(4):
            client = stack.enter_context(socket.socket())
            client.setblocking(False)
            client.connect_ex(server.getsockname())
        folder = new(f"{directory}/hanging", "--subjects", "1", "--conditions", "a", "--duration", "1s", source=[
            "--", "--sensor", "stream", "--port", f"127.0.0.1:{server.getsockname()[1]}"])
        with Terminal("session", "run", folder) as terminal:
            terminal.wait_for(": opening")
            time.sleep(0.5)
            began = time.monotonic()
            terminal.type(" q")
            check(terminal.end() == 0, terminal.text)
            check(time.monotonic() - began < 5, f"q took {time.monotonic() - began:.1f} s")
            terminal.check_restored()
        check(log(folder) == [], "no device, no attempt")


def check_fits(terminal, columns, lines):
    frames = terminal.frames
    while terminal.frames == frames:
        terminal.read()
    shown = terminal.screen.split("\n")
    check(len(shown) <= lines and max(map(len, shown)) <= columns, f"{columns} x {lines}: {shown}")


# --- a folder of another program ---

def table(rms_um=200, seconds=1.5, rate=10000, noise=7):
    """A CSV of 225 Hz with this RMS, and noise that no other file has."""
    time_s = numpy.arange(int(seconds * rate)) / rate
    value_mm = 1e-3 * rms_um * 2**0.5 * numpy.sin(2 * numpy.pi * 225 * time_s)
    value_mm += 1e-4 * numpy.random.default_rng(noise).standard_normal(len(time_s))
    return "time_s,displacement_mm\n" + "".join(f"{t:.4f},{x:.7f}\n" for t, x in zip(time_s, value_mm))


def write(path, text, seconds=0.0):
    """As another program does: piece by piece, within some seconds."""
    pieces = 8 if seconds else 1
    with open(path, "w", encoding="utf-8") as file:
        for piece in range(pieces):
            file.write(text[len(text) * piece // pieces:len(text) * (piece + 1) // pieces])
            file.flush()
            time.sleep(seconds / pieces)


def content(folder):
    return {name: open(f"{folder}/{name}", "rb").read() for name in sorted(os.listdir(folder))}


def next_file(folder, expected=0, wait="20s"):
    return json.loads(run("session", "next", folder, "--wait", wait, "--json", status=expected).stdout)


def folder_source(directory):
    """Files that were there, grow for seconds, come two at once, are broken, touched, written over and continued."""
    daq, folder = f"{directory}/daq", f"{directory}/day"
    os.mkdir(daq)
    write(f"{daq}/before.csv", table(noise=1))
    source = ["--", "--from-folder", daq, "--pattern", "*.csv", "--unchanged", "0.6s"]
    for wrong in (["--", "--from-folder", f"{directory}/none"], [*source, "--port", "/dev/ttyUSB0"],
                  ["--", "--from-folder", daq, "--unchanged", "0s"], ["--", "--from-folder", ""]):
        said = run("session", "new", folder, "--subjects", "1", "--conditions", "a", "--duration", "1s", *wrong, status=2)
        check(said.stderr.count("\n") == 1 and not os.path.exists(folder), said.stderr)
    new(folder, "--subjects", "2", "--conditions", "a,b", "--order", "given", "--repeats", "2", "--duration", "1.5s",
        "--expect", "tone=225Hz+-1Hz", source=source)
    check("no new file" in run("session", "next", folder, "--wait", "1s", status=3).stderr, "what was there is not taken")
    # grows for two seconds, with pauses shorter than what makes it complete
    writing = threading.Thread(target=write, args=(f"{daq}/run1.csv", table(noise=2), 2))
    writing.start()
    began = time.monotonic()
    first = next_file(folder)
    writing.join()
    check(time.monotonic() - began > 2, "a file that grows is not taken")
    check(first["verdict"] == "GOOD" and first["condition"] == "a" and abs(first["band_rms_m"] * 1e6 - 200) < 0.5, first)
    check_import(first, f"{daq}/run1.csv", folder)
    same_numbers(first, f"{daq}/run1.csv")
    # two at once, in order of time, and of names where that is the same
    for name, noise in (("run3.csv", 4), ("run2.csv", 3)):
        write(f"{daq}/{name}", table(rms_um=100 + noise, noise=noise))
    for name in ("run2.csv", "run3.csv"):
        os.utime(f"{daq}/{name}", ns=(10**18, 10**18))
    for name in ("run2.csv", "run3.csv"):
        taken = next_file(folder)
        check(info(taken["file"])["fields"]["import.file"] == name, taken)
    # a touched file is no new one
    os.utime(f"{daq}/run2.csv")
    run("session", "next", folder, "--wait", "2s", status=3)
    # a broken one is named, BAD, and left as it is
    write(f"{daq}/broken.csv", "time_s,displacement_mm\n0,1\n0.1,kaputt\n")
    broken = next_file(folder, 3)
    check(broken["verdict"] == "BAD" and "broken.csv" in broken["reasons"][0], broken)
    check("broken.csv" in ended(folder, ("1", "b", "2"))["reason"], log(folder)[-1])
    check(status(folder)["findings"] == [], "that it has no file is said by its attempt")
    run("session", "relabel", folder, "--condition", "a", "--reason", "x")
    run("session", "relabel", folder, "--condition", "b", "--reason", "y")
    check("broken.csv" in status(folder)["attempts"][-1]["reasons"], status(folder)["attempts"][-1])
    # an empty one is named
    write(f"{daq}/empty.csv", "")
    said = run("session", "next", folder, "--wait", "2s", status=3).stderr
    check("empty.csv is empty" in said and "no new file" not in said, said)
    # redo takes the next file for the same cell
    write(f"{daq}/again.csv", table(noise=5))
    again = json.loads(run("session", "redo", folder, "--json").stdout)
    check((again["condition"], again["repeat"], again["attempt"]) == ("b", 2, 2), again)
    # the same name with another content is a new trial; one that goes on is a new attempt of its cell
    write(f"{daq}/again.csv", table(noise=6, seconds=0.7))
    other = next_file(folder, 3)
    check((other["subject"], other["attempt"]) == ("2", 1), other)
    check(other["reasons"] == ["it ended after 0.7 of 1.5 s"], other)
    write(f"{daq}/again.csv", table(noise=6))
    # the cell that is recorded is announced
    said = run("session", "next", folder, "--wait", "20s", "--json")
    continued = json.loads(said.stdout)
    check("again.csv, which continues one of before: " + name_of(continued) in said.stderr, said.stderr)
    check((continued["subject"], continued["condition"], continued["attempt"]) == ("2", other["condition"], 2), continued)
    # killed while it waits, and between its lines: the file is taken once
    killed_while_importing(folder, daq)
    counts = status(folder)
    check(counts["good"] == 6 and counts["bad"] == 0, counts)
    before = content(daq)
    from_screen(folder, daq)
    check({name: text for name, text in content(daq).items() if name in before} == before, "no file is touched")
    study = json.loads(run("study", folder, "--json").stdout)
    check(study["counts"]["answered"] == 8, study["counts"])


def kinds(directory):
    """Recordings of every kind: as trial.bin with times of arrival, HDF5, with a gap, with labels of their own."""
    daq, folder = f"{directory}/daq", f"{directory}/kinds"
    os.mkdir(daq)
    new(folder, "--subjects", "1", "--conditions", "a,b,c,d", "--order", "given", "--duration", "1s",
        source=["--", "--from-folder", daq, "--pattern", "*.*", "--unchanged", "0.3s"])
    run("trial", "export", "fixtures/recorded_trial.bin", "-o", f"{directory}/recorded.h5")
    lines = table(seconds=2).splitlines(True)
    gap = "# subject = somebody else\n# condition = none of the plan\n" + "".join(lines[:8000] + lines[8600:])
    with open(f"{directory}/gap.csv", "w", encoding="utf-8") as file:
        file.write(gap)
    with Emulator("--protocol", "stream", "--baud", "921600", "--link", f"{directory}/port") as emulator:
        run("acquire", "--sensor", "stream", "--port", emulator.port, "--duration", "1.5s", "--label", "subject=9", "-o",
            f"{directory}/arrival.bin")
    for condition, path in zip("abcd", ("fixtures/recorded_trial.bin", f"{directory}/recorded.h5", f"{directory}/gap.csv",
                                        f"{directory}/arrival.bin")):
        shutil.copy(path, daq)
        done = subprocess.run([program("haptometer"), "session", "next", folder, "--json"], capture_output=True, check=False)
        outcome = json.loads(done.stdout)
        check(outcome["verdict"] in ("GOOD", "CHECK") and outcome["condition"] == condition, outcome)
        header = info(outcome["file"])
        check(header["labels"] == {**header["labels"], "subject": "1", "condition": condition}, header["labels"])
        check(header["fields"]["import.file"] == os.path.basename(path), header["fields"])
        same_numbers(outcome, path)


def check_import(outcome, path, folder):
    header = info(outcome["file"])
    with open(path, "rb") as file:
        digest = hashlib.sha256(file.read()).hexdigest()
    check(header["fields"]["import.sha256"] == digest, header["fields"])
    check(header["source"] == "imported from " + os.path.basename(path), header)
    begin = [line for line in log(folder) if line["event"] == "begin"][-1]
    check(digest in begin["reason"] and os.path.basename(path) in begin["reason"], begin)


def same_numbers(outcome, path):
    """The trial gives the numbers that the file itself gives."""
    numbers = [json.loads(run("analyze", name, "--json").stdout)["trials"][0] for name in (outcome["file"], path)]
    for key in ("band_rms_m", "band_rms_standard_uncertainty_m", "tone_frequency_hz", "sample_rate_hz", "window_s"):
        check(numbers[0][key] == numbers[1][key], f"{key}: {numbers[0][key]} {numbers[1][key]}")


def killed_while_importing(folder, daq):
    write(f"{daq}/killed.csv", table(noise=8))
    begun = len(log(folder))
    process = subprocess.Popen([program("haptometer"), "session", "next", folder], stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    wait_for("the attempt", lambda: len(log(folder)) > begun or process.poll() is not None)
    process.send_signal(signal.SIGKILL)
    process.wait(DEADLINE_S)
    # before the kill it may have come to its end
    if log(folder)[-1]["event"] == "begin":
        check(info(next_file(folder)["file"])["fields"]["import.file"] == "killed.csv", "it is taken again")
    ends = [line for line in log(folder) if line["event"] == "end"]
    check(ends[-1]["verdict"] == "GOOD", ends[-1])
    run("session", "next", folder, "--wait", "1.5s", status=3)


def from_screen(folder, daq):
    """At the screen no key is needed."""
    with Terminal("session", "run", folder) as terminal:
        terminal.wait_for("waiting for a file")
        write(f"{daq}/screen1.csv", table(noise=9), 1.5)
        terminal.wait_for("GOOD +subject 2, a, repeat 2")
        terminal.wait_for("waiting for a file")
        # the next file is of the last cell
        terminal.type("r")
        terminal.wait_for("subject 2, a, repeat 2 +attempt 2")
        write(f"{daq}/screen2.csv", table(noise=10))
        terminal.wait_for("subject 2, b, repeat 2 +attempt 1")
        write(f"{daq}/screen3.csv", table(noise=11))
        terminal.wait_for("all cells are done")
        write(f"{daq}/screen4.csv", table(noise=12))
        time.sleep(1.5)
        terminal.wait_for("no file is waited for")
        terminal.type("q")
        check(terminal.end() == 0, terminal.text)
        terminal.check_restored()
    check(status(folder)["good"] == 8 and status(folder)["next"] is None, status(folder))
    check("screen4" not in open(f"{folder}/log.csv", encoding="utf-8").read(), "nothing behind the plan is taken")


# --- kill -9, and a full disk ---

def kills(directory, count=6):
    """kill -9 at random moments of `session run`: after each the state is one of before and after the step, every byte
    is there, and the next one continues at the right cell."""
    seed = random.randrange(1 << 32)
    moments = random.Random(seed)
    cells = max(6, count)
    folder = new(f"{directory}/kills", "--subjects", "1", "--conditions", "a", "--repeats", str(cells), "--duration",
                 "0.6s", source=SCENE_SOURCE)
    begun = 0
    for _ in range(count):
        known, said = status(folder), open(f"{folder}/log.csv", "rb").read()
        trials = content(f"{folder}/trials")
        with Terminal("session", "run", folder) as terminal:
            terminal.wait_for(": ready")
            terminal.type(" ")
            time.sleep(0.12 * moments.random())
            terminal.kill(signal.SIGKILL)
            check(terminal.end() == -signal.SIGKILL, terminal.status)
        after = status(folder)
        check(open(f"{folder}/log.csv", "rb").read().startswith(said), f"the log is only appended to, seed {seed}")
        for name, text in trials.items():
            check(open(f"{folder}/trials/{name}", "rb").read().startswith(text), f"{name} has changed, seed {seed}")
        check(after["done"] - known["done"] in (0, 1) and after["bad"] == 0, f"seed {seed}: {known} {after}")
        check((after["next"] == known["next"]) == (after["done"] == known["done"]), f"seed {seed}: {known} {after}")
        begun += after["attempts_not_ended"] - known["attempts_not_ended"]
    print(f"{count} kills of seed {seed}, {begun} of them in an attempt, {status(folder)['done']} trials done")
    while status(folder)["next"]:
        run("session", "next", folder)
    study = json.loads(run("study", folder, "--json").stdout)
    check(study["counts"]["answered"] == cells and study["counts"]["without_value"] == 0, study["counts"])


def disk(directory):
    """In a namespace of its own, where a small disk can be mounted; skipped where that is not allowed."""
    if subprocess.run(["unshare", "-rm", "true"], capture_output=True, check=False).returncode != 0:
        skip("this system permits no mounts in a namespace of one's own")
    sys.exit(subprocess.run(["unshare", "-rm", "/usr/bin/python3", __file__, "full_disk"], check=False).returncode)


def fill(directory, leave):
    free = os.statvfs(directory)
    with open(f"{directory}/hog", "wb") as file:
        os.posix_fallocate(file.fileno(), 0, free.f_bavail * free.f_frsize - leave)


def full_disk(directory):
    """A disk that is full before and within a recording, and at an import: stated, nothing lost, and it continues."""
    small = f"{directory}/small"
    os.mkdir(small)
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=2m", "tmpfs", small], check=True)
    try:
        recorded(small)
        imported(small)
    finally:
        subprocess.run(["umount", small], check=True)


def recorded(directory):
    folder = new(f"{directory}/day", "--subjects", "1", "--conditions", "a,b,c", "--order", "given", "--duration", "1s",
                 source=SCENE_SOURCE)
    with Terminal("session", "run", folder) as terminal:
        terminal.wait_for(": ready")
        record(terminal, " ", "GOOD", "subject 1, a, repeat 1")
        before = content(f"{folder}/trials")
        for attempt, leave in ((2, 0), (3, 24576)):
            fill(directory, leave)
            terminal.type(" ")
            terminal.wait_for(f"subject 1, b, repeat 1 +attempt {attempt}")
            terminal.wait_for("No space left")
            terminal.wait_for(": ready")
            os.unlink(f"{directory}/hog")
            check({name: content(f"{folder}/trials")[name] for name in before} == before, "nothing is lost")
        terminal.type(" ")
        terminal.wait_for("GOOD +subject 1, b, repeat 1")
        record(terminal, " ", "GOOD", "subject 1, c, repeat 1")
        terminal.type("q")
        check(terminal.end() == 0, terminal.text)
    check(status(folder)["good"] == 3, status(folder))


def imported(directory):
    with tempfile.TemporaryDirectory(dir="/dev/shm" if os.path.isdir("/dev/shm") else None) as daq:
        folder = new(f"{directory}/files", "--subjects", "1", "--conditions", "a", "--duration", "1s",
                     source=["--", "--from-folder", daq, "--unchanged", "0.3s"])
        with Terminal("session", "run", folder) as terminal:
            terminal.wait_for("waiting for a file")
            fill(directory, 24576)
            write(f"{daq}/a.csv", table())
            terminal.wait_for("SPACE tries it again")
            terminal.wait_for("No space left")
            begun = len(log(folder))
            time.sleep(1)
            check(len(log(folder)) == begun, "no attempts without an end")
            os.unlink(f"{directory}/hog")
            terminal.type(" ")
            terminal.wait_for("GOOD +subject 1, a, repeat 1")
            terminal.type("q")
            check(terminal.end() == 0, terminal.text)


PARTS = {"keys": (keys, verdict_in_time), "device": (lambda directory: device(directory, float(sys.argv[2]) if len(sys.argv) > 2 else 3),), "ending": (refused_plans, ending, clock_set_back), "folder": (folder_source, kinds, kills), "disk": (disk,),
         "full_disk": (full_disk,), "kills": (lambda directory: kills(directory, int(sys.argv[2])),)}

if __name__ == "__main__":
    began = time.monotonic()
    for part in PARTS[sys.argv[1]]:
        with tempfile.TemporaryDirectory() as made:
            part(made)
    print(f"passed in {time.monotonic() - began:.1f} s")
