#!/usr/bin/env python3
"""Hostile text in every place that a file, a name or a device can put it, through every verb that
prints, draws or writes: nothing of it is ever executed, no control character reaches an output, and
every picture, page, table and document that comes out is well-formed.

A canary is a file that a payload would make. Recordings with such texts are written here, byte by
byte from docs/reference/formats.md, because the program refuses to make them."""

import csv
import html.parser
import io
import json
import math
import os
import pathlib
import re
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import xml.etree.ElementTree
import zlib

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import DEADLINE_S, check, program  # noqa: E402

ROOT = pathlib.Path.cwd()
SPOOF = "\n  file            finished by a payload"
PAYLOADS = [
    "x\n!touch CANARY1\n",
    "x'\n!touch CANARY2\n'",
    "\r!touch CANARY3\r",
    "`touch CANARY4`",
    "'; system('touch CANARY5') #",
    '"; system("touch CANARY6"); "',
    "$(touch CANARY7)",
    "|touch CANARY8",
    "\\\n!touch CANARY9\nEOD\n!touch CANARY10\n",
    "\x1b[2J\x1b]0;title\x07\x9b31m\x7f",
    "nul\0nul",
    "<script>CANARY()</script> ]]> & <!-- \"q\"",
    "%s %n %d 50 %",
    "@x ^2 _e ~a{.8-} {/Symbol a} &{b}",
    "\u202egnp.exe\u2028line\ufffe",
    SPOOF,
]
EVIL = " ".join(PAYLOADS)
FORMULA = "=cmd|' /C calc'!A0"
FORBIDDEN = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ufffe\uffff]")


# --- an independent writer of trial.bin (docs/reference/formats.md) ---

def block(kind, sequence, payload, rows=0, first=0):
    head = struct.pack("<8s4IQqI", b"\x93block\r\n", kind, sequence, rows, len(payload), first, first,
                       zlib.crc32(payload))
    return head + struct.pack("<I", zlib.crc32(head)) + payload


def write_trial(path, text, labels=None, gain=1e-5, seconds=2.5, rate=4000, drive_v=None):
    """A sine of 175 Hz with `text` in every place of the header that takes one."""
    times = np.arange(int(seconds * rate)) / rate
    noise = np.random.default_rng(7).normal(0, gain / 50, times.size)
    values = gain * np.sin(2 * math.pi * 175 * times) + noise
    row = np.zeros(times.size, np.dtype([("v", "<f8"), ("s", "u1")]))
    row["v"] = values
    channel = {"name": text, "role": "displacement", "unit": "m", "encoding": "f64", "scale": 1,
               "offset": 0, "range_min": None, "range_max": None, "resolution": 0}
    header = {"format": "haptometer trial", "timing": "uniform", "rate_hz": rate,
              "channels": [channel]}
    for key in ("source", "sensor", "head", "hold", "laser_spot", "utc_start", "host",
                "command_line"):
        header[key] = text
    header["labels"] = {text: text, **(labels or {})}
    header["fields"] = {text: text}
    header["notes"] = [text]
    header["drive_amplitude_v"] = drive_v
    header = json.dumps(header).encode()
    data = b"\x93haptrial\r\n\x1a\n\x01\xfe\x00" + block(1, 0, header) + block(1, 1, header)
    piece = 4096
    sequence = 2
    for first in range(0, row.size, piece):
        part = row[first:first + piece]
        data += block(2, sequence, part.tobytes(), part.size, first)
        sequence += 1
    for event in ({"event": "remark", "row": 1, "time_ns": 0, "text": text},
                  {"event": text, "row": 1, "text": text},
                  {"event": "labels", "row": 1, "text": text, "labels": {"later" + text: text}}):
        data += block(3, sequence, json.dumps(event).encode(), 0, row.size)
        sequence += 1
    totals = {"rows": int(row.size), "statuses": {"ok": int(row.size)}}
    data += block(4, sequence, json.dumps(totals).encode(), 0, row.size)
    pathlib.Path(path).write_bytes(data)


# --- what every run must keep ---

class Page(html.parser.HTMLParser):
    def handle_starttag(self, tag, attributes):
        check(tag not in ("script", "iframe", "object"), f"a page holds <{tag}>")
        check(not any(name.startswith("on") for name, _ in attributes), f"<{tag} {attributes}>")


def check_text(text, what):
    try:
        text = text.decode("utf-8")
    except UnicodeDecodeError as error:
        sys.exit(f"FAILED: {what} is no UTF-8: {error}")
    found = FORBIDDEN.search(text)
    check(not found, f"{what} holds {found and found.group()!r}: {text[:400]!r}")
    for line in text.splitlines():
        check(not line.startswith(("!touch", "  file            finished by a payload")),
              f"{what} holds a line of a payload's: {line!r}")


def check_files(folder):
    check(not list(folder.rglob("CANARY*")), "a payload was executed")
    for path in sorted(folder.rglob("drawn*")):
        if path.suffix == ".svg":
            xml.etree.ElementTree.parse(path)
        elif path.suffix == ".html":
            page = path.read_text(encoding="utf-8")
            check(not FORBIDDEN.search(page), f"{path} holds a control character")
            Page().feed(page)
            for figure in re.findall(r"<svg.*?</svg>", page, re.S):
                xml.etree.ElementTree.fromstring(figure)
        elif path.suffix in (".csv", ".md", ".toml"):
            check_text(path.read_bytes(), str(path))
        else:
            continue
        path.unlink()


class Runner:
    def __init__(self, folder):
        self.folder = folder
        self.runs = 0

    def __call__(self, *words, statuses=(0,), data=b""):
        """`haptometer WORDS` in the folder, looked at; its output."""
        words = [word if isinstance(word, bytes) else str(word).encode() for word in words]
        done = subprocess.run([program("haptometer").encode(), *words], input=data, cwd=self.folder,
                              capture_output=True, timeout=DEADLINE_S)
        self.runs += 1
        check(done.returncode in statuses,
              f"{words} ends with {done.returncode}: {done.stderr[-600:]}")
        check_text(done.stdout, f"standard output of {words}")
        check_text(done.stderr, f"standard error of {words}")
        if b"--json" in words and done.returncode == 0:
            json.loads(done.stdout)
        if done.returncode == 2:
            check(done.stderr.count(b"\n") == 1, f"{words}: {done.stderr}")
        check_files(self.folder)
        return done.stdout.decode()


def file_name(text):
    """As much of `text` as a file's name takes."""
    return text.replace("\0", "").replace("/", "")


# --- the places ---

def trials(run):
    for number, payload in enumerate([*PAYLOADS, EVIL]):
        write_trial(run.folder / "evil.bin", payload)
        shown = run("trial", "info", "evil.bin")
        check("finished by its recorder" in shown and "label" in shown, shown)
        if number % 3 == 0 or payload is EVIL:
            run("trial", "plot", "evil.bin", "--plot", "drawn.svg")
    run("trial", "info", "evil.bin", "--json")
    for form in ("drawn.csv", "all.h5", "one.npy", "one.mat"):
        run("trial", "export", "evil.bin", "-o", form, "--overwrite")
    run("trial", "export", "evil.bin")
    run("trial", "info", "all.h5")
    run("trial", "label", "evil.bin", "subject=3")
    for words in (["trial", "label", "evil.bin", "subject=a\nb"],
                  ["trial", "label", "evil.bin", "a\x1b=b"],
                  ["trial", "label", "evil.bin", "a=b", "--reason", "a\rb"],
                  ["trial", "exclude", "evil.bin", "--reason", "a\x1bb"]):
        run(*words, statuses=(2,))
    run("analyze", "evil.bin", "--all", "--plot", "drawn.svg", "--report", "drawn.html",
        "--spectrum", "drawn2.svg", "--spectrogram", "drawn3.svg")
    run("analyze", "evil.bin", "--json", "--spectrum", "drawn.csv")
    run("analyze", "evil.bin", "evil.bin", "all.h5", "missing\n\x1b", statuses=(1, 2, 3))
    run("analyze", "evil.bin", "--sweep", "--plot", "drawn.svg", "--response", "drawn.csv",
        statuses=(0, 3))


def file_names(run):
    """Names and folders of files, which belong to whoever made them."""
    names = ["|touch CANARY8", "-x", "`touch CANARY4`", "a'b\"$(touch CANARY7)", b"latin\xfc\xff",
             file_name(EVIL)[:200]]
    for name in names:
        stem = name if isinstance(name, bytes) else name.encode()
        folder = os.path.join(str(run.folder).encode(), stem + b" folder")
        os.mkdir(folder)
        write_trial(os.path.join(folder, stem + b".bin").decode("utf-8", "surrogateescape"), "fine")
        path = stem + b" folder/" + stem + b".bin"
        path = b"./" + path
        run("trial", "info", path)
        run("trial", "info", path, "--json")
        run("analyze", path, "--plot", "drawn.svg", "--report", "drawn.html")
        run("trial", "plot", path, "--plot", path + b".svg", statuses=(0, 2))
        run("trial", "export", path, "-o", path + b".csv", statuses=(0, 2))
        run("trial", "info", path + b"missing", statuses=(3,))
        shutil.rmtree(folder)


def foreign_files(run):
    tail = "".join(f"{n / 4000},{math.sin(n)}\n" for n in range(4000))
    one_line = re.sub("[\n\r\0]", " ", EVIL)
    text = "# a table\n" * 60 + f"# label.{one_line} = {one_line}\n# source = {one_line}\n" \
           f"# {one_line} = {one_line}\n# note = {one_line}\n# channel.1.name = {one_line}\n" \
           "time_s,displacement_m\n" + tail
    (run.folder / "t.csv").write_text(text, encoding="utf-8")
    run("trial", "info", "t.csv")
    run("trial", "info", "t.csv", "--json")
    run("trial", "plot", "t.csv", "--plot", "drawn.svg")
    run("analyze", "t.csv", "--report", "drawn.html", statuses=(0, 3))
    cell = re.sub("[,;\t]", " ", one_line)
    (run.folder / "t.csv").write_text(f"# a\ntime_s,{cell}\n" + tail, encoding="utf-8")
    run("trial", "info", "t.csv", statuses=(0, 3))
    (run.folder / "t.csv").write_text("# a\ntime_s,displacement_m\n" + tail + f"1,{cell}\n",
                                      encoding="utf-8")
    run("trial", "info", "t.csv", statuses=(3,))
    lvm = "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\tOne\n" \
          f"Description\t{'d' * 600}{cell}\n***End_of_Header***\t\nChannels\t1\n" \
          f"Y_Unit_Label\t{cell}\n***End_of_Header***\t\nX_Value\t{cell}\tComment\n" \
          + "".join(f"{n / 4000}\t{n % 7}\t{cell if n < 3 else ''}\n" for n in range(100))
    (run.folder / "t.lvm").write_text(lvm, encoding="utf-8")
    run("trial", "info", "t.lvm")
    run("trial", "plot", "t.lvm", "--plot", "drawn.svg")
    # exports whose header was changed afterwards: its texts have a fixed length
    mark = "M" * 400
    write_trial(run.folder / "mark.bin", mark)
    evil = json.dumps(EVIL)[1:-1].encode()[:400].rsplit(b"\\", 1)[0]
    for form in ("mark.h5", "mark.npy", "mark.mat"):
        run("trial", "export", "mark.bin", "-o", form)
        changed = (run.folder / form).read_bytes().replace(mark.encode(), evil.ljust(400, b"~"))
        (run.folder / form).write_bytes(changed)
        check("touch CANARY1" in run("trial", "info", form), "the change is not read")
        run("trial", "plot", form, "--plot", "drawn.svg")
    # names of the columns of another program's file
    field = re.sub(r"['\\\\]", " ", one_line)
    head = f"{{'descr': [('time_s', '<f8'), ('{field}', '<f8')], 'fortran_order': False, 'shape': (50,), }}\n".encode()
    rows = b"".join(struct.pack("<dd", n / 4000, n % 7) for n in range(50))
    (run.folder / "t.npy").write_bytes(b"\x93NUMPY\2\0" + struct.pack("<I", len(head)) + head + rows)
    run("trial", "info", "t.npy")
    run("analyze", "t.npy", statuses=(3,))


def sessions(run):
    """Names of a plan and a log that somebody else wrote."""
    scene = pathlib.Path("fixtures/lra_adapter.toml").resolve()
    words = ["--subjects", "1", "--duration", "0.6s", "--", "--sensor", f"scene:{scene}", "--speed", "max"]
    for number, payload in enumerate([*PAYLOADS, EVIL]):
        name = payload.replace("\0", "").replace(",", ";").strip()
        made = run("session", "new", f"s{number}", "--conditions", name, *words, statuses=(0, 2))
        if made:
            run("session", "next", f"s{number}", statuses=(0, 3))
            run("session", "reject", f"s{number}", "--reason", name or "x", statuses=(0, 2))
            run("session", "accept", f"s{number}", "--reason", name or "x", statuses=(0, 2))
            run("session", "status", f"s{number}", "--all")
            run("session", "status", f"s{number}", "--json")
    run("session", "new", "s", "--conditions", "a", *words)
    cell = '"' + EVIL.replace('"', '""').replace("\n", " ") + '"'
    for file in (cell, "../evil.bin", "a.bin"):
        line = f"u,end,1,a,1,1,{file},GOOD,{cell},"
        line += f"{zlib.crc32(line.encode()):08x}\n"
        with open(run.folder / "s" / "log.csv", "ab") as log:
            log.write(line.encode())
    run("session", "status", "s", "--all")
    run("session", "redo", "s", statuses=(0, 3))
    (run.folder / "s" / "session.toml").write_text('subjects = ["a\\u001b"]\n', encoding="utf-8")
    run("session", "status", "s", statuses=(2, 3))


def studies(run):
    folder = run.folder / "study"
    folder.mkdir()
    names = {"subject": ["s1", "s2", EVIL], "condition": ["stock", EVIL, FORMULA]}
    number = 0
    for subject in names["subject"]:
        for at, condition in enumerate(names["condition"]):
            write_trial(folder / f"{number}.bin", EVIL, {"subject": subject, "condition": condition},
                        gain=(1 + at + 0.1 * number + 0.03 * (number % 4)) * 1e-5, seconds=1.5, drive_v=1 + at)
            number += 1
    shown = json.loads(run("study", "study", "--json"))
    check(len(shown["trials"]) == 9 and all(trial["answered"] for trial in shown["trials"]),
          json.dumps(shown["trials"])[:600])
    evil = next(name for name in (t["condition"] for t in shown["trials"]) if "CANARY1" in name)
    run("study", "study", "--all", "--contrast", f"{FORMULA}:stock", "--plot", "drawn.svg",
        "--methods", "drawn.md", "--table", "long.csv", "--wide", "wide.csv")
    if ":" not in evil:
        run("study", "study", "--contrast", f"{evil}:stock", "--plot", "drawn.svg")
    for table in ("long.csv", "wide.csv"):
        text = (run.folder / table).read_bytes()
        check_text(text, table)
        for row in csv.reader(io.StringIO(text.decode())):
            for cell in row:
                check(cell[:1] not in "=+-@\t\r" or cell == "" or re.fullmatch(r"[-+.\de]+", cell),
                      f"{table} holds {cell!r}")
    run("study", "compare", "study", ROOT / "fixtures" / "lra_adapter.toml", "--table", "cells.csv", "--plot", "drawn.svg", "--report", "page.html",
        statuses=(3,))
    check_text((run.folder / "cells.csv").read_bytes(), "cells.csv")
    run("study", "linearity", *(f"study/{n}.bin" for n in range(9)), "--plot", "drawn.svg",
        statuses=(0, 3))
    for text in ('files = "*.bin"\ncondition = "a\\nb"', 'conditions = ["a\\u001b"]',
                 '"evil\\nkey" = 1', 'pattern = "{subject}\\u0007_{condition}"'):
        (run.folder / "study" / "m.toml").write_text(
            f"[[trials]]\n{text}\n" if text.startswith("files") else text + "\n", encoding="utf-8")
        run("study", "study/m.toml", "--plot", "drawn.svg", statuses=(2,))
    # a pattern takes labels from names of files
    named = run.folder / "named"
    named.mkdir()
    for subject in ("s1", "s2"):
        for at, condition in enumerate(("stock", file_name(EVIL)[:150])):
            write_trial(str(named / f"{subject}_{condition}.bin"), "fine",
                        gain=(1 + at + int(subject[1]) / 10 * (1 - at)) * 1e-5,
                        seconds=1.5)
    run("study", "named", "--pattern", "{subject}_{condition}", "--plot", "drawn.svg", "--table",
        "drawn.csv")
    # and a table that people fill in
    table = (ROOT / "fixtures" / "matching.csv").read_text(encoding="utf-8")
    cell = re.sub("[,\"\n\r\0:]", " ", EVIL)
    (run.folder / "m.csv").write_text(table.replace("stock", cell).replace("ia1", "'" + FORMULA),
                                      encoding="utf-8")
    document = json.loads(run("study", "matching", "m.csv", "--json"))
    check(FORMULA in json.dumps(document), "an own cell does not come back as it was")
    run("study", "matching", "m.csv", "--plot", "drawn.svg")


def fits(run):
    fixture = (ROOT / "fixtures" / "impulse.csv").read_text(encoding="utf-8")
    one_line = re.sub("[\n\r\0]", " ", EVIL)
    drop = file_name(EVIL)[:150] + ".csv"
    (run.folder / drop).write_text(f"# note = {one_line}\n# {one_line} = {one_line}\n" + fixture,
                                   encoding="utf-8")
    run("fit-lra", "./" + drop, "--plot", "drawn.svg", "--report", "drawn.html", "--save",
        "drawn.toml", statuses=(0, 3))
    run("fit-lra", "./" + drop, "--json", statuses=(0, 3))
    run("fit-lra", "--adapter", "./" + drop, "--mass", "2g", statuses=(0, 3))
    actuator = "name = \"a\\nb\"\nsource = \"\\u001b\"\n"
    (run.folder / "a.toml").write_text(actuator, encoding="utf-8")
    run("fit-lra", "./" + drop, "--actuator", "a.toml", statuses=(2, 3))
    run("sweep", ROOT / "fixtures" / "lra_direct.toml", "--vary", "drive.frequency_hz=60:400:25", "-o",
        "s.csv", "--plot", "drawn.svg")
    rows = [line for line in (run.folder / "s.csv").read_text().splitlines() if line[:1] != "#"]
    sweep = "frequency_hz,displacement_rms_m,current_rms_a\n" + "".join(
        f"{row['drive.frequency_hz']},{row['skin_rms_m']},{row['current_rms_a']}\n"
        for row in csv.DictReader(rows))
    (run.folder / drop).write_text(sweep, encoding="utf-8")
    run("fit-skin", "./" + drop, "--actuator", "thesis-c10-100", "--plot", "drawn.svg",
        statuses=(0, 3))
    run("fit-skin", "./" + drop, "--actuator", "thesis-c10-100", "--json", statuses=(0, 3))
    cell = re.sub("[,\"\n\r\0]", " ", EVIL)
    (run.folder / "z.csv").write_text(f"frequency_hz,impedance_ohm,{cell}\n100,27,{cell}\n",
                                      encoding="utf-8")
    run("fit-lra", "--impedance", "z.csv", "--moving-mass", "1.4g", statuses=(2, 3))
    for words in (["--plot", "a\nb.svg"], ["--report", "a\x1b.html"], ["--save", "a\rb.toml"]):
        run("fit-lra", ROOT / "fixtures" / "impulse.csv", *words, statuses=(2,))


def scenes(run):
    scene = file_name(EVIL)[:150] + ".toml"
    shutil.copy(ROOT / "fixtures" / "lra_adapter.toml", run.folder / scene)
    scene = "./" + scene
    run("simulate", scene, "--duration", "0.1s", "--plot", "drawn.svg", "--waveforms", "drawn.csv")
    run("simulate", scene, "--duration", "0.1s", "--json")
    # a header names the scene
    run("simulate", scene, "--duration", "0.5s", "-o", "scene.bin")
    run("trial", "info", "scene.bin")
    run("sweep", scene, "--vary", "drive.frequency_hz=100:200:3", "--vary",
        "drive.amplitude_v=1,2", "-o", "sweep.csv", "--plot", "drawn.svg")
    run("sweep", scene, "--vary", "drive.frequency_hz=100:200:3", "-o", "x\n.csv", statuses=(2,))
    run("sweep", scene, "--vary", "drive.kind=a\nb", "-o", "x.csv", statuses=(2,))
    table = (run.folder / "sweep.csv").read_text(encoding="utf-8")
    cell = re.sub("[,\"\n\r\0]", " ", EVIL)
    (run.folder / "sweep.csv").write_text(
        table.replace("drive.amplitude_v", cell).replace("# scene = ", "# scene = " + cell),
        encoding="utf-8")
    run("sweep", "--merge", "sweep.csv", "-o", "merged.csv", "--plot", "drawn.svg",
        statuses=(0, 1, 2, 3))
    (run.folder / "result.json").write_text(json.dumps(
        {"trials": [{"file": EVIL, "answered": True, "band_rms_m": 1e-4, "band_rms_standard_uncertainty_m": 1e-6,
                     "data_source": ["device"]}],
         "findings": [{"severity": "doubt", "text": EVIL, "subject": EVIL}]}), encoding="utf-8")
    run("compare", "result.json", scene, "--plot", "drawn.svg", "--report", "page.html", statuses=(3,))
    run("compare", "result.json", scene, "--input", "a\x1b=1+-1", statuses=(2,))
    run("tune", scene, "--springs", "6500", "--motor-side-mass", "1g:1.01g", "--skin-side-mass",
        "1g:1.01g", "--damping", "0.04:0.041", "--contact-area", "20:20.1", "--plot",
        "drawn.svg", "--report", "page.html", "--all", statuses=(0, 3))
    for text in ('[actuator]\nname = "a\\nb"\n', '"a\\u001b" = 1\n', "x = '\x1b'\n", "\x1b\n",
                 "[drive]\nkind = \"sine\\u2028\"\n"):
        (run.folder / "s.toml").write_text(text, encoding="utf-8")
        run("simulate", "s.toml", statuses=(2, 3))
        run("acquire", "--daemon", "s.toml", statuses=(2, 3))
    run("reproduce", "--report", "a'b\"$(touch CANARY7) `touch CANARY4`.html", statuses=(0, 3))
    run("reproduce", "--report", "a\nb.html", statuses=(2,))
    run("reproduce", "--figures", "a\x1bb", statuses=(2,))


def recordings(run):
    numbers = "".join(f"{n % 50}\n" for n in range(2000)).encode()
    pipe = ["acquire", "--sensor", "pipe", "--format", "text", "--rate", "1kHz"]
    for payload in (*PAYLOADS, EVIL):
        payload = payload.replace("\0", "")
        if FORBIDDEN.search(payload) or "\n" in payload:
            for words in (["--channels", payload], ["--channels", "a:" + payload],
                          ["--channels", "a", "--label", "subject=" + payload],
                          ["--channels", "a", "--label", payload + "=1"]):
                run(*pipe, *words, "-o", "new.bin", statuses=(2,), data=numbers)
            run(*pipe, "--channels", "a", "-o", file_name(payload) + ".bin", statuses=(2,),
                data=numbers)
        else:
            run(*pipe, "--channels", "a", "--label", "note=" + payload, "-o", "new.bin",
                "--overwrite", data=numbers)
            check(payload in run("trial", "info", "new.bin"), f"{payload} is not shown as it is")
    run(*pipe, "--channels", "a", "-o", b"\xff\xfe.bin", statuses=(2,), data=numbers)
    # what a device sends, and what an argument says
    run(*pipe, "--channels", "a", "-o", "heading.bin", "--overwrite",
        data=EVIL.encode() + b"\n" + numbers, statuses=(0, 1, 3))
    run(*pipe, "--channels", "a", "-o", "none.bin", data=EVIL.encode() + b"\n", statuses=(1, 3))
    run(*pipe, "--channels", "a", "--live", data=numbers)
    run("acquire", "--list-ports")
    run("acquire", "--port", "/dev/none\n\x1b", "-o", "p.bin", statuses=(2,))
    for words in ([EVIL], ["trial", EVIL], ["--" + EVIL], ["analyze", "--" + EVIL],
                  ["analyze", "--band", EVIL, "x"], ["simulate", "--duration", "\x1bs", "x"],
                  ["emulate", "--link", "a\nb"]):
        run(*(word.replace("\0", "") for word in words), statuses=(1, 2, 3))


def talking(server, answer):
    """Says `answer` at once and to every question, until nobody listens."""
    while True:
        try:
            peer, _ = server.accept()
        except OSError:
            return
        with peer:
            try:
                peer.sendall(answer)
                while peer.recv(4096):
                    peer.sendall(answer)
            except OSError:
                pass


def devices(run):
    """A device that says anything, to every question."""
    for sensor in ("keyence-il", "keyence-en1", "keyence-lkg", "stream", "modbus"):
        with socket.create_server(("127.0.0.1", 0)) as server:
            thread = threading.Thread(target=talking, args=(server, (EVIL + "\r\n").encode()))
            thread.start()
            words = ["--port", "127.0.0.1:%d" % server.getsockname()[1], "--sensor", sensor]
            words += ["--profile", "wt53r"] if sensor == "modbus" else []
            run("acquire", "--check", *words, "--duration", "500ms", statuses=(1, 3))
            if sensor in ("keyence-il", "stream"):
                run("acquire", *words, "-o", "d.bin", "--duration", "500ms", statuses=(1, 3))
            server.shutdown(socket.SHUT_RDWR)
        thread.join()


def answering(server, answer):
    while True:
        try:
            peer, _ = server.accept()
        except OSError:
            return
        with peer:
            try:
                peer.settimeout(0.2)
                peer.recv(4096)
            except OSError:
                pass
            try:
                peer.sendall(answer)
            except OSError:
                pass


def status(run):
    """Anything may answer on a socket."""
    sensor = {"name": EVIL, "port": EVIL, "sensor": EVIL, "state": "recording", "since_utc": EVIL,
              "file": EVIL, "readings": 1, "bad": 0, "gaps": 0, "lost": 0, "reconnects": 0,
              "disk_waits": 0, "last_error": EVIL}
    for answer, statuses in ((json.dumps({"config": EVIL, "utc": EVIL, "sensors": [sensor]}), (0,)),
                             (json.dumps({"sensors": [{"state": EVIL}]}), (3,)), (EVIL, (1, 3))):
        path = run.folder / "s.sock"
        server = socket.socket(socket.AF_UNIX)
        server.bind(str(path))
        server.listen()
        thread = threading.Thread(target=answering, args=(server, answer.encode()))
        thread.start()
        run("acquire", "--status", "s.sock", statuses=statuses)
        run("acquire", "--status", "s.sock", "--json", statuses=statuses)
        server.shutdown(socket.SHUT_RDWR)
        server.close()
        thread.join()
        path.unlink()


PARTS = [trials, file_names, foreign_files, sessions, studies, fits, scenes, recordings, devices, status]


def main():
    names = sys.argv[1:]
    runs = 0
    for part in PARTS:
        if names and part.__name__ not in names:
            continue
        with tempfile.TemporaryDirectory() as name:
            run = Runner(pathlib.Path(name))
            part(run)
            check_files(run.folder)
            runs += run.runs
    print(f"{runs} runs, nothing executed")


if __name__ == "__main__":
    main()
