"""A session of four trials against the emulator, typed by a script: killed in the middle of a trial (kill -9), a second
command at the same time, a trial done again, rejected and relabelled, a log that was cut, and nothing is lost or
overwritten; `study` then needs no manifest.

  tests/system/session_test.py [KILLS]
"""
import csv
import hashlib
import io
import json
import math
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import DEADLINE_S, SCENE, Emulator, check, info, program, run, wait_for

SECONDS = "1s"


def status(folder):
    return json.loads(run("session", "status", folder, "--json").stdout)


def log(folder):
    with open(f"{folder}/log.csv", encoding="utf-8", newline="") as file:
        return file.read()


def lines(folder):
    return list(csv.DictReader(io.StringIO(log(folder))))


def trials(folder):
    """The files with their sizes and the bytes that they begin with."""
    # a trial is renamed once it is begun: NAME.new may be gone when it is read
    names = [name for name in os.listdir(f"{folder}/trials") if not name.endswith(".new")]
    return {name: open(f"{folder}/trials/{name}", "rb").read() for name in names}


def nothing_lost(before, folder):
    """Every file is there, and every byte that it had: events are appended only."""
    after = trials(folder)
    for name, content in before.items():
        check(after.get(name, b"").startswith(content), f"{name} has changed")
    return after


def start(*words):
    return subprocess.Popen([program("haptometer"), "session", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def killed_in_a_trial(folder):
    """kill -9 while a trial is recorded: the cell stays open, and what was recorded stays."""
    before = trials(folder)
    known, begun = status(folder), len(lines(folder))
    process = start("next", folder)
    wait_for("the attempt", lambda: len(lines(folder)) > begun and len(trials(folder)) > len(before))
    # a second command is refused meanwhile, and one that only reads is not
    refused = run("session", "next", folder, status=1).stderr
    check("in use by another command" in refused, refused)
    check(status(folder)["next"] == known["next"], "a trial that is being recorded is no cell")
    process.send_signal(signal.SIGKILL)
    process.communicate(timeout=DEADLINE_S)
    after = status(folder)
    check(after["next"] == known["next"] and after["done"] == known["done"], "the killed cell stays open")
    check(after["attempts_not_ended"] == known["attempts_not_ended"] + 1, after)
    nothing_lost(before, folder)


def record(folder, word="next", expected=0):
    before = trials(folder)
    cell = status(folder)["next"]
    done = subprocess.run([program("haptometer"), "session", word, folder, "--json"], capture_output=True,
                          timeout=DEADLINE_S)
    check(done.returncode == expected, f"{word} ends with {done.returncode}: {done.stdout.decode()}")
    outcome = json.loads(done.stdout)
    nothing_lost(before, folder)
    check(len(trials(folder)) == len(before) + 1, "an attempt is a new file")
    if word == "next":
        check({key: outcome[key] for key in cell} == cell, f"{outcome} is not of {cell}")
    header = info(outcome["file"])
    check(header["labels"]["subject"] == outcome["subject"], header)
    with open(f"{folder}/session.toml", "rb") as plan:
        check(header["fields"]["session.plan_sha256"] == hashlib.sha256(plan.read()).hexdigest(), header["fields"])
    return outcome


def excluded(path):
    return info(path)["fields"].get("excluded", "")


def day(folder, port):
    source = ["--", "--sensor", "stream", "--baud", "921600", "--port", port]
    new = ["session", "new", folder, "--subjects", "2", "--conditions", "stock,cone", "--duration", SECONDS,
           "--expect", "tone=225Hz+-1Hz", "--seed", "3"]
    said = json.loads(run(*new, "--json", *source).stdout)
    check(said["planned"] == 4 and said["recording_s"] == 4, said)
    check("not an empty folder" in run(*new, *source, status=2).stderr, "a session is never written over")
    first = record(folder)
    check(first["verdict"] == "GOOD" and abs(first["tone_frequency_hz"] - 225) < 0.1, first)
    check(excluded(first["file"]) == "", "a trial that ended counts")
    killed_in_a_trial(folder)
    # before any other command: its header says so
    killed = [line["file"] for line in lines(folder) if line["event"] == "begin"][1]
    check(excluded(f"{folder}/trials/{killed}") == "session: interrupted", "a study leaves the killed one out at once")
    second = record(folder)
    check(second["attempt"] == 2, f"the number of the killed attempt is not given again: {second}")
    check(excluded(f"{folder}/trials/{killed}") == "session: interrupted", "a study leaves the killed one out")
    # rejected, done again: the new attempt counts, and the file of the old one is excluded
    run("session", "reject", folder, "--reason", "finger slipped, twice")
    check(excluded(second["file"]) == "session: rejected: finger slipped, twice", "rejected")
    check(status(folder)["bad"] == 1, status(folder))
    again = record(folder, "redo")
    check(again["attempt"] == 3 and status(folder)["done"] == 2 and status(folder)["bad"] == 0, status(folder))
    check(excluded(second["file"]) == "session: rejected: finger slipped, twice; a later attempt counts",
          excluded(second["file"]))
    return again


def relabelled(folder):
    """To another cell and back: labels and counts follow, and the log has both."""
    third = record(folder)
    other = "stock" if third["condition"] == "cone" else "cone"
    said = run("session", "relabel", folder, "--condition", other, "--reason", "adapters swapped").stderr
    check(f"is now subject {third['subject']}, {other}, repeat 1: GOOD, and counts" in said, said)
    check(info(third["file"])["labels"]["condition"] == other, "the trial has the new label")
    check(status(folder)["next"]["condition"] == third["condition"], status(folder))
    run("session", "relabel", folder, "--condition", third["condition"], "--reason", "they were not")
    check(info(third["file"])["labels"]["condition"] == third["condition"], "and the old one again")
    check(excluded(third["file"]) == "", "it counts")
    for words in (["--condition", "other", "--reason", "x"], ["--condition", other],
                  ["--file", "none.bin", "--condition", other, "--reason", "x"],
                  ["--floor", "--condition", other, "--reason", "x"], ["--condition", other, "--reason", ""]):
        before = log(folder)
        run("session", "relabel", folder, *words, status=2)
        check(log(folder) == before, "a refused relabelling leaves no line")


def remarked(directory):
    """A skipped cell comes again behind the others; notes and skips change no trial."""
    folder = f"{directory}/remarks"
    run("session", "new", folder, "--subjects", "1", "--conditions", "a,b", "--order", "given", "--duration", "0.6s",
        "--", "--sensor", f"scene:{SCENE}", "--speed", "max")
    run("session", "note", folder, "--text", "cold room")
    counts = json.loads(run("session", "skip", folder, "--reason", "a is broken", "--json").stdout)
    check(counts["next"]["condition"] == "b" and counts["skipped_count"] == 1, counts)
    first = record(folder)
    before = trials(folder)
    run("session", "note", folder, "--text", "cold finger")
    counts = status(folder)
    check(counts["attempts"][0]["notes"] == "cold finger", counts)
    check([one["notes"] for one in counts["cell_notes"]] == ["cold room"], counts)
    check(counts["skipped"][0]["reason"] == "a is broken", counts)
    check(counts["next"]["condition"] == "a", "what was skipped comes again")
    check(trials(folder) == before, "a note changes no trial")
    for words in (["note", folder], ["note", folder, "--text", " "], ["note", folder, "--text", "x", "--file", "none"],
                  ["skip", folder], ["skip", folder, "--reason", ""]):
        said = log(folder)
        check(run("session", *words, status=2).stderr.count("\n") == 1 and log(folder) == said, words)
    check(record(folder)["condition"] == "a" and status(folder)["skipped_count"] == 0, first)
    check("is done" in run("session", "skip", folder, "--reason", "x", status=3).stderr, "nothing to skip")


def planned(directory):
    """Drive, contrasts and limits of the plan; floors, repeats, and what is done to trials by hand."""
    folder = f"{directory}/planned"
    source = ["--", "--sensor", f"scene:{SCENE}", "--speed", "max"]
    said = json.loads(run("session", "new", folder, "--subjects", "8", "--conditions", "cone,cones", "--repeats", "3",
                          "--order", "given", "--duration", "0.6s", "--drive-frequency", "230Hz", "--drive-amplitude",
                          "5V", "--contrast", "cones:cone", "--spread", "10%", "--json", *source).stdout)
    kinds = {one["kind"] for one in said["findings"]}
    texts = " ".join(one["text"] for one in said["findings"])
    check("cone and cones differ by one letter" in texts, texts)
    check({"planned-names-alike", "scale-not-checked"} <= kinds, kinds)
    # tests/dsp/statistics/power_reference.csv
    check(abs(said["detectable_effect_d_z"] - 1.156035) < 1e-6, said)
    check(abs(said["detectable_difference"] - 0.1156035) < 1e-7, said)
    first = record(folder, expected=3)
    check(first["reasons"] == ["the tone is at 225 Hz; 230 Hz +- 2.3 Hz is expected"], first)
    check(info(first["file"])["drive_frequency_hz"] == 225, "the scene states its drive itself")
    # done again, and the old one included by hand: the cell counts once
    again = record(folder, "redo", expected=3)
    second = record(folder, expected=3)
    run("trial", "exclude", second["file"], "--reason", "by hand")
    run("trial", "label", again["file"], "condition=cones")
    counts = status(folder)
    check(counts["done"] == 2 and counts["excluded_by_user"] == 1, counts)
    check({"excluded-by-user", "labels-by-hand"} == {one["kind"] for one in counts["findings"]}, counts["findings"])
    run("trial", "label", again["file"], "condition=cone")
    record(folder, expected=3)
    # a condition of the plan without a trial: answered for the others, and named
    for words in ([], ["--contrast", "cones:cone"]):
        study = json.loads(run("study", folder, "--json", *words).stdout)
        found = [one["subject"] for one in study["findings"] if one["kind"] == "contrast-not-yet"]
        check(found == ["cones against cone"] and study["contrasts"] == [], study["findings"])
    check("is the condition of no trial" in run("study", folder, "--contrast", "cons:cone", status=2).stderr, "a typing error")
    run("trial", "include", second["file"])
    # what the session excludes is not included by hand: nothing is changed
    before = trials(folder)
    said = run("trial", "include", first["file"], status=2).stderr
    check(said.count("\n") == 1 and "a later attempt counts" in said and "session accept" in said, said)
    check(trials(folder) == before, "refused, and nothing is changed")
    study = json.loads(run("study", folder, "--json", status=3).stdout)
    check(study["contrasts_planned"] and study["contrasts"][0]["treatment"] == "cones", "contrasts of the plan")
    kinds = {one["kind"] for one in study["findings"]}
    check("labels-alike" in kinds and not {"contrast-not-yet", "table-ignored"} & kinds, study["findings"])
    left = [one for one in study["trials"] if one["excluded"]]
    check([(one["file"], one["excluded"]) for one in left] == [(first["file"], "session: a later attempt counts")], left)
    # all excluded: a refusal
    for attempt in status(folder)["attempts"]:
        if not excluded(f"{folder}/trials/{attempt['file']}"):
            run("session", "reject", folder, "--file", attempt["file"], "--reason", "x")
    said = json.loads(run("study", folder, "--json", status=3).stdout)
    check("all-excluded" in {one["kind"] for one in said["findings"]}, said["findings"])


RATE = 10000
PIPE = ["--", "--sensor", "pipe", "--format", "text", "--rate", f"{RATE}Hz", "--channels", "displacement:m"]
NOISE = random.Random(5)


def samples(amplitude_m, distance_m=0.03, seconds=1.5, noise_m=2e-6):
    """225 Hz of this amplitude, and white noise."""
    return "".join(f"{distance_m + amplitude_m * math.sin(2 * math.pi * 225 * k / RATE) + noise_m * NOISE.gauss(0, 1):.9f}\n"
                   for k in range(int(seconds * RATE))).encode()


def from_pipe(folder, amplitude_m, expected=0, words=("next",), **options):
    return json.loads(run("session", words[0], folder, *words[1:], "--json", data=samples(amplitude_m, **options),
                          status=expected).stdout)


def floors(directory):
    """The subject's floor is subtracted from its later trials, in the session and in its study."""
    folder = f"{directory}/floors"
    run("session", "new", folder, "--subjects", "1", "--conditions", "a", "--floor", "per-subject", "--repeats", "4",
        "--duration", "1.5s", "--drive-frequency", "225Hz", "--drive-amplitude", "5V", "--expect",
        "repeats<10%, bad<1%, steady>1s, distance=30mm+-2mm", *PIPE)
    # a floor that is BAD, or too short, comes again before the trials
    check(from_pipe(folder, 50e-6, 3)["next"]["is_floor"], "a drive was on")
    short = from_pipe(folder, 0, 3, seconds=1.2)
    check(short["verdict"] == "CHECK" and short["next"]["is_floor"] and "ended after 1.2" in short["reasons"][0], short)
    floor = from_pipe(folder, 0)
    check(floor["is_floor"] and floor["verdict"] == "GOOD" and floor["noise_floor"] is None, floor)
    check(not floor["next"]["is_floor"], floor)
    name = os.path.basename(floor["file"])
    header = info(floor["file"])
    check([header["drive_frequency_hz"], header["drive_amplitude_v"]] == [225, 5], "as planned")
    for amplitude_m in (50e-6, 51e-6):
        good = from_pipe(folder, amplitude_m)
        check(good["verdict"] == "GOOD" and good["noise_floor"] == name, good)
    other = from_pipe(folder, 65e-6, 3)
    check(other["verdict"] == "CHECK" and "from the median of the earlier repeats" in other["reasons"][0], other)
    moved = from_pipe(folder, 50e-6, 3, distance_m=-0.03)
    check(any("check the polarity" in reason for reason in moved["reasons"]), moved)

    def study_floors():
        study = json.loads(run("study", folder, "--json").stdout)
        return study, [os.path.basename(one["file"]) for one in study["subject_floors"]]

    study, named = study_floors()
    check(named == [name] and study["subject_floors"][0]["subject"] == "1", study["subject_floors"])
    # 2 um of white noise in 480 of 5000 Hz
    check(abs(study["subject_floors"][0]["rms_m"] / (2e-6 * math.sqrt(480 / 5000)) - 1) < 0.1, "the floor's RMS")
    answered = [one for one in study["trials"] if one["answered"]]
    check(len(answered) == 4 and good["band_rms_m"] in [one["band_rms_m"] for one in answered], study["trials"])
    # one that is excluded by hand is not subtracted: the one before is, or none
    later = from_pipe(folder, 0, words=("floor",))
    run("trial", "exclude", later["file"], "--reason", "somebody walked by")
    again = ("redo", "--file", good["file"])
    redone = from_pipe(folder, 50e-6, words=again)
    check(redone["noise_floor"] == name and study_floors()[1] == [name], redone)
    run("trial", "exclude", floor["file"], "--reason", "by hand too")
    redone = from_pipe(folder, 50e-6, words=again)
    check(redone["noise_floor"] is None and study_floors()[1] == [], redone)
    # and included again: what the session says of it holds, and it is subtracted
    run("trial", "include", floor["file"])
    check(excluded(floor["file"]) == "session: floor, drive off" and study_floors()[1] == [name], excluded(floor["file"]))
    # what a floor hides has a limit and no RMS
    from_pipe(folder, 0, words=("floor",), noise_m=4e-6)
    hidden = from_pipe(folder, 1.53e-6, 3, words=again)
    check(hidden["verdict"] == "CHECK" and hidden["band_rms_m"] is None, hidden)
    check(any("below the noise floor" in reason for reason in hidden["reasons"]), hidden)


def decisions(directory):
    """Relabelled trials are judged again in their new cell; what is rejected can be accepted again."""
    folder = f"{directory}/decisions"
    run("session", "new", folder, "--subjects", "1", "--conditions", "a,b", "--order", "given", "--repeats", "3",
        "--floor", "per-subject", "--duration", "1.5s", "--expect", "repeats<10%", *PIPE)
    floor = from_pipe(folder, 0)
    for amplitude_m in (50e-6, 100e-6, 50.5e-6, 101e-6):
        check(from_pipe(folder, amplitude_m)["verdict"] == "GOOD", amplitude_m)
    # b was mounted for a: CHECK, and GOOD where it belongs; both stand in the line of the relabelling
    wrong = from_pipe(folder, 100.5e-6, 3)
    check(wrong["condition"] == "a" and "from the median" in wrong["reasons"][0], wrong)
    before = open(wrong["file"], "rb").read()
    run("session", "relabel", folder, "--condition", "b", "--reason", "b was mounted")
    line = lines(folder)[-1]
    check((line["event"], line["verdict"], line["reason"]) == ("relabel", "GOOD", "b was mounted"), line)
    check(abs(float(line["band_rms_m"]) / wrong["band_rms_m"] - 1) < 1e-9, line)
    counts = status(folder)
    check([counts["good"], counts["check"], counts["next"]["condition"]] == [5, 0, "a"], counts)
    # killed between the log and the trial: the trial as it was before; the next command mends it
    with open(wrong["file"], "wb") as file:
        file.write(before)
    check("labels-by-hand" in {one["kind"] for one in status(folder)["findings"]}, status(folder)["findings"])
    run("session", "note", folder, "--text", "goes on")
    check(info(wrong["file"])["labels"]["condition"] == "b" and not status(folder)["findings"], status(folder)["findings"])
    run("session", "relabel", folder, "--condition", "a", "--reason", "it was not")
    check(lines(folder)[-1]["verdict"] == "CHECK" and "from the median" in lines(folder)[-1]["reason"], lines(folder)[-1])
    # a drive is on where a floor should be, and the other way round
    run("session", "relabel", folder, "--floor", "--reason", "no")
    check(status(folder)["attempts"][-1]["verdict"] == "BAD" and "a drive is on" in lines(folder)[-1]["reason"], lines(folder)[-1])
    check(info(wrong["file"])["labels"] == {**info(wrong["file"])["labels"], "condition": "", "repeat": ""}, "no condition")
    said = run("session", "relabel", folder, "--condition", "a", "--reason", "which one?", status=2).stderr
    check("--repeat is missing" in said.replace(":", ""), said)
    run("session", "relabel", folder, "--condition", "a", "--repeat", "3", "--reason", "yes")
    quiet = from_pipe(folder, 0, 3)
    check(quiet["condition"] == "b" and quiet["verdict"] == "BAD", quiet)
    said = run("session", "relabel", folder, "--floor", "--reason", "the drive was off").stderr
    check("is now subject 1, floor: GOOD, and counts" in said, said)
    check(excluded(quiet["file"]) == "session: floor, drive off", excluded(quiet["file"]))
    good = from_pipe(folder, 100e-6)
    check(good["condition"] == "b" and good["noise_floor"] == os.path.basename(quiet["file"]), good)
    # an older attempt that is relabelled does not push a later one aside
    said = run("session", "relabel", folder, "--file", wrong["file"], "--condition", "b", "--reason", "x").stderr
    check("GOOD, but a later attempt counts: " + os.path.basename(good["file"]) in said, said)
    run("session", "relabel", folder, "--file", wrong["file"], "--condition", "a", "--reason", "y")
    # rejected by a wrong key, twice, and back again; also where it is relabelled meanwhile
    for reason in ("wrong key", "again"):
        run("session", "reject", folder, "--reason", reason)
    check(excluded(good["file"]) == "session: rejected: wrong key; again", excluded(good["file"]))
    check(status(folder)["attempts"][-1]["reasons"] == "rejected: wrong key; again", status(folder)["attempts"][-1])
    run("session", "relabel", folder, "--condition", "a", "--reason", "x")
    check(status(folder)["attempts"][-1]["verdict"] == "BAD", "it stays rejected")
    run("session", "relabel", folder, "--condition", "b", "--reason", "y")
    said = run("session", "accept", folder, "--reason", "it was good").stderr
    check("GOOD, and counts" in said and excluded(good["file"]) == "" and status(folder)["bad"] == 0, said)
    check("unchanged" in run("session", "accept", folder, "--reason", "x", status=2).stderr, "nothing to accept")
    # an older attempt counts until a newer one ends
    again = from_pipe(folder, 99e-6, words=("redo", "--file", good["file"]))
    check((again["condition"], again["repeat"], again["attempt"]) == ("b", 3, 2), again)
    run("session", "accept", folder, "--file", good["file"], "--reason", "the first was better")
    check(excluded(good["file"]) == "" and excluded(again["file"]) == "session: a later attempt counts", "accepted")
    newest = from_pipe(folder, 99e-6, words=("redo",))
    check(excluded(newest["file"]) == "" and excluded(good["file"]) != "", "a newer one has ended")
    first = next(one["file"] for one in status(folder)["attempts"] if one["condition"] == "a")
    redone = from_pipe(folder, 50e-6, words=("redo", "--file", first))
    check((redone["condition"], redone["repeat"], redone["attempt"]) == ("a", 1, 2), redone)
    run("session", "redo", folder, "--file", "none.bin", status=2)
    # a path has to be that of a trial here
    elsewhere_ = f"{directory}/{os.path.basename(redone['file'])}"
    check("is no file in" in run("session", "reject", folder, "--file", elsewhere_, "--reason", "x", status=2).stderr, elsewhere_)
    # accepted, and still excluded by hand
    run("trial", "exclude", newest["file"], "--reason", "by hand")
    run("session", "reject", folder, "--file", newest["file"], "--reason", "x")
    said = run("session", "accept", folder, "--file", newest["file"], "--reason", "y").stderr
    check("until trial include includes it" in said, said)
    run("trial", "include", newest["file"])
    check(excluded(newest["file"]) == "", newest)
    # what a trial's header states otherwise than the log is pointed out, and does not count
    before = open(redone["file"], "rb").read()
    run("session", "reject", folder, "--reason", "x")
    with open(redone["file"], "wb") as file:
        file.write(before)
    found = [(one["kind"], one["subject"]) for one in status(folder)["findings"]]
    check(found == [("excluded-otherwise", os.path.basename(redone["file"]))], found)
    study = json.loads(run("study", folder, "--json", status=3).stdout)
    check({one["file"]: one["excluded"] for one in study["trials"]}[redone["file"]] == "session: rejected: x", "the log decides")
    check(floor["verdict"] == "GOOD" and status(folder)["damaged_lines"] == 0, status(folder))


def torn(folder):
    """A log that ends in a part of a line: what was whole counts, and going on starts a new line."""
    whole = log(folder)
    last = whole.rstrip("\n").rfind("\n") + 1
    before = status(folder)
    with open(f"{folder}/log.csv", "w", encoding="utf-8", newline="") as file:
        file.write(whole + whole[last:last + 30])
    check(status(folder)["next"] == before["next"] and status(folder)["done"] == before["done"], "a torn line")
    outcome = record(folder)
    check(outcome["verdict"] == "GOOD", outcome)
    check("log-damaged" in {one["kind"] for one in status(folder)["findings"]}, status(folder)["findings"])
    said = run("session", "note", folder, "--text", "x").stderr
    check(said.count("1 line of log.csv cannot be read") == 1, said)
    check(log(folder).startswith(whole + whole[last:last + 30] + "\n"), "the log is only appended to")
    check(status(folder)["damaged_lines"] == 1, status(folder))


def ended(folder):
    counts = status(folder)
    check([counts[key] for key in ("planned", "done", "good", "check", "bad")] == [4, 4, 4, 0, 0], counts)
    check(counts["next"] is None, counts)
    check("is done" in run("session", "next", folder, status=3).stderr, "nothing is left to record")
    study = json.loads(run("study", folder, "--json").stdout)
    check(study["counts"]["answered"] == 4 and study["counts"]["excluded"] == 2, study["counts"])
    check(study["missing"] == [] and study["subjects"] == ["1", "2"], study["missing"])
    check("session-log-damaged" in {one["kind"] for one in study["findings"]}, study["findings"])
    # a trial of another day among its own, and a label that was changed by hand: the log decides
    own = next(one["file"] for one in study["trials"] if not one["excluded"])
    stranger = f"{folder}/trials/0_of_another_day.bin"
    shutil.copy(own, stranger)
    run("trial", "label", own, "condition=other")
    again = json.loads(run("study", folder, "--json").stdout)
    check(again["contrasts"] == study["contrasts"] and again["counts"]["answered"] == 4, again["counts"])
    found = {one["file"]: one["excluded"] for one in again["trials"]}
    check(found[stranger] == "session: it is not in log.csv" and not found[own], found)
    os.remove(stranger)


def other_limits(folder, port):
    """230 Hz is expected and 225 Hz is there: CHECK, with the reason."""
    run("session", "new", folder, "--subjects", "ann", "--conditions", "a", "--duration", SECONDS, "--expect",
        "tone=230Hz+-1Hz", "--floor", "per-subject", "--", "--sensor", "stream", "--baud", "921600", "--port", port)
    floor = record(folder, expected=3)
    check(floor["is_floor"] and floor["verdict"] == "BAD" and floor["reasons"] == ["a drive is on"], floor)
    check(floor["next"]["is_floor"], "it comes again at once, until it is skipped")
    run("session", "skip", folder, "--reason", "the drive does not stop")
    checked = record(folder, expected=3)
    check(checked["verdict"] == "CHECK" and "230 Hz +- 1 Hz is expected" in checked["reasons"][0], checked)
    counts = status(folder)
    check(counts["done"] == counts["check"] == 1 and counts["floors"] == {"planned": 1, "done": 0}, counts)
    check(counts["next"]["is_floor"], "the floor that was skipped comes at the end")


def killed_at_any_moment(folder, kills):
    """kill -9 at random moments of `session next`: after each the state is one of before and after the step, and every
    byte is there. In the end each cell is done once for a study."""
    seed = random.randrange(1 << 32)
    moments = random.Random(seed)
    print(f"moments of seed {seed}")
    cells = max(6, kills // 2)
    run("session", "new", folder, "--subjects", "2", "--conditions", "a", "--repeats", str(cells // 2), "--duration",
        "0.6s", "--", "--sensor", f"scene:{SCENE}", "--speed", "max")
    process, took_s = start("next", folder), time.monotonic()
    check(process.wait(DEADLINE_S) == 0, process.communicate())
    took_s = time.monotonic() - took_s
    for _ in range(kills):
        before, known, said = trials(folder), status(folder), log(folder)
        process = start("next", folder)
        time.sleep(1.2 * took_s * moments.random())
        process.send_signal(signal.SIGKILL)
        process.communicate(timeout=DEADLINE_S)
        after = status(folder)
        nothing_lost(before, folder)
        check(log(folder).startswith(said), f"the log is only appended to, seed {seed}")
        check(after["done"] - known["done"] in (0, 1) and after["bad"] == 0, f"seed {seed}: {known} {after}")
        check((after["next"] == known["next"]) == (after["done"] == known["done"]), f"seed {seed}: {known} {after}")
    while status(folder)["next"]:
        record(folder)
    counts = status(folder)
    check(counts["good"] == counts["planned"], counts)
    study = json.loads(run("study", folder, "--json").stdout)
    check(study["counts"]["answered"] == counts["planned"], f"seed {seed}: {study['counts']}")
    check(study["counts"]["without_value"] == 0, f"seed {seed}: {study['counts']}")
    print(f"{kills} kills, {counts['attempts_not_ended']} attempts did not end, {counts['planned']} cells")


def refusals(folder):
    """Wrong plans and folders: one line, and nothing is made."""
    good = ["--subjects", "2", "--conditions", "a,b", "--duration", "1s"]
    source = ["--", "--port", "/dev/none"]
    for words, status_ in (([*good], 2), ([*good, "--", "-o", "x.bin"], 2), ([*good, "--", "--nonsense"], 2),
                           (["--subjects", "2", "--conditions", "a,A", "--duration", "1s", *source], 2),
                           (["--subjects", "0", "--conditions", "a", "--duration", "1s", *source], 2),
                           (["--subjects", "2", "--conditions", "a\nb", "--duration", "1s", *source], 2),
                           ([*good, "--expect", "tone", *source], 2), ([*good[:4], *source], 2),
                           ([*good, "--expect", "", *source], 2), ([*good, "--contrast", "a:c", *source], 2),
                           ([*good, "--contrast", "a", *source], 2), ([*good, "--spread", "10", *source], 2),
                           ([*good, "--spread", "", *source], 2), ([*good, "--drive-frequency", "0Hz", *source], 2),
                           (["--subjects", "-2", *good[2:], *source], 2), (["--subjects", "2.5", *good[2:], *source], 2),
                           (["--subjects", "", *good[2:], *source], 2), ([*good[:2], *good[4:], *source], 2),
                           ([*good, "--contrast", "a:b", "--contrast", "a:b", *source], 2),
                           ([*good, "--contrast", "a:b", "--contrast", "b:a", *source], 2),
                           ([*good, "--expect", "averaging=x", *source], 2)):
        said = run("session", "new", folder, *words, status=status_).stderr
        check(said.count("\n") == 1 and said.startswith("haptometer session new: "), f"one line: {said}")
        check(words[1] != "" or "leave it out" not in said, said)
        check(not os.path.exists(folder), f"{words} leaves a folder")
    for word in ("next", "redo", "status", "floor"):
        check("is not a session" in run("session", word, folder, status=3).stderr, word)
    said = run("session", "new", folder, *good[:4], "--repeats", "999", "--duration", "3s", *source).stdout
    check("3.33 h" in said and "design is not complete" not in said, said)
    said = run("session", "new", f"{folder}_3", "--subjects", "3", *good[2:], *source).stdout
    check("a multiple of 2, and they are 3" in said, said)
    check(run("session", "next", folder, status=3).stderr.count("\n") == 2, "a device that is not there")
    check(len(lines(folder)) == 0, "no device, no attempt")


def contents(folder):
    """Every file below a folder, with its bytes."""
    return {os.path.join(at, name): open(os.path.join(at, name), "rb").read()
            for at, _, names in os.walk(folder) for name in names}


def elsewhere(directory):
    """A plan means the same source from every directory, and a closed standard error costs no status."""
    day = os.path.abspath(f"{directory}/elsewhere")
    with open(SCENE, encoding="utf-8") as file, open(f"{directory}/here.toml", "w", encoding="utf-8") as copy:
        copy.write(file.read())
    here = os.getcwd()
    os.chdir(directory)
    try:
        run("session", "new", day, "--subjects", "1", "--conditions", "a,b", "--duration", "0.6s", "--",
            "--sensor", "scene:here.toml", "--speed", "max")
    finally:
        os.chdir(here)
    run("session", "next", day)
    with open("/dev/full", "w", encoding="utf-8") as full:
        status = subprocess.run([program("haptometer"), "session", "next", day], stdout=subprocess.DEVNULL,
                                stderr=full, check=False).returncode
    check(status == 0, f"standard error that cannot be written: status {status}")


def foreign(directory):
    """Files of others in place of a session's: one line, and nothing is touched."""
    source = ["--subjects", "1", "--conditions", "a", "--duration", "0.6s", "--", "--sensor", f"scene:{SCENE}",
              "--speed", "max"]
    folder = f"{directory}/foreign"
    os.mkdir(folder)
    with open(f"{folder}/thesis.txt", "w", encoding="utf-8") as file:
        file.write("of somebody else")
    before = contents(folder)
    for place, status_ in ((folder, 2), (f"{folder}/thesis.txt", 2), (f"{folder}/thesis.txt/day", 1)):
        said = run("session", "new", place, *source, status=status_).stderr
        check(said.count("\n") == 1, said)
    check(contents(folder) == before, "session new touches nothing of others")
    for k, (name, text) in enumerate((("session.toml", b"subjects = 3"), ("session.toml", b"\xff\x00\x1b[2J"), ("session.toml", b""),
                                      ("session.toml", b"[[trials]]\nfiles = 'a'"), ("session.toml", None), ("log.csv", None))):
        day = f"{directory}/day_{k}"
        run("session", "new", day, *source)
        os.remove(f"{day}/{name}")
        if text is None:
            os.mkdir(f"{day}/{name}")
        else:
            with open(f"{day}/{name}", "wb") as file:
                file.write(text)
        before = contents(day)
        for words in (["next", day], ["status", day], ["skip", day, "--reason", "x"], ["note", day, "--text", "x"]):
            done = subprocess.run([program("haptometer"), "session", *words], capture_output=True, timeout=DEADLINE_S)
            check(done.returncode in (1, 2, 3) and done.stderr.count(b"\n") == 1 and b"\x1b" not in done.stderr,
                  f"{name} {text}: {words[0]}: {done.returncode} {done.stderr}")
        check(contents(day) == before, f"{name} {text}: nothing is touched")
    # what lies among the trials is none of the session's
    day = f"{directory}/strangers"
    run("session", "new", day, *source)
    with open(f"{day}/trials/notes.txt", "w", encoding="utf-8") as file:
        file.write("of somebody else")
    record(day)
    check(contents(day)[f"{day}/trials/notes.txt"] == b"of somebody else", "a file of others stays")
    file = f"{day}/trials/{lines(day)[0]['file']}"
    os.rename(file, file + ".new")
    kinds = [(one["kind"], one["severity"]) for one in status(day)["findings"]]
    check(kinds == [("trial-missing", "doubt"), ("header-unfinished", "note"), ("file-unknown", "doubt")], kinds)
    os.rename(file + ".new", file)
    # saved by a program for spreadsheets: the lines end with CR LF
    text = log(day)
    with open(f"{day}/log.csv", "w", encoding="utf-8", newline="") as saved:
        saved.write(text.replace("\n", "\r\n"))
    check(status(day)["good"] == 1 and status(day)["damaged_lines"] == 0, status(day))


if __name__ == "__main__":
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as directory:
        with Emulator("--protocol", "stream", "--baud", "921600", "--link", f"{directory}/port") as emulator:
            day(f"{directory}/day", emulator.port)
            relabelled(f"{directory}/day")
            torn(f"{directory}/day")
            ended(f"{directory}/day")
            other_limits(f"{directory}/limits", emulator.port)
        remarked(directory)
        planned(directory)
        floors(directory)
        decisions(directory)
        killed_at_any_moment(f"{directory}/kills", int(sys.argv[1]) if len(sys.argv) > 1 else 12)
        refusals(f"{directory}/wrong")
        foreign(directory)
        elsewhere(directory)
    print(f"passed in {time.monotonic() - began:.1f} s")
