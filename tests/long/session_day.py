"""A day of 96 trials and 8 floors: keys are sent to `session run` in a real terminal (tmux), with redo, reject, relabel
and its undo, and skip. Before each trial the emulated device is changed for one with the drive of the trial's condition,
on the same port, so the screen meets 104 losses of its device. Then `study` has to find the truth of each condition.

  tests/long/session_day.py build/release/bin [SUBJECTS]
"""
import csv
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
os.environ["HAPTOMETER_PROGRAMS"] = sys.argv[1]
import programs
from programs import SCENE, Emulator, check, info, program, run, skip

VOLTS = {"none": 0.0, "stock": 2.0, "cone": 3.0, "grip": 4.0, "adapter": 5.0}
CONDITIONS = ["stock", "adapter", "cone", "grip"]


class Tmux:
    """A terminal of tmux with a server of its own."""

    def __init__(self, directory, *words):
        self.tmux = ["tmux", "-S", f"{directory}/tmux", "-f", "/dev/null"]
        command = " ".join(f"'{word}'" for word in [program("haptometer"), *words])
        subprocess.run([*self.tmux, "new-session", "-d", "-x", "150", "-y", "40", f"{command}; sleep 1000"], check=True)

    def screen(self):
        return subprocess.run([*self.tmux, "capture-pane", "-p"], check=True, capture_output=True, text=True).stdout

    def keys(self, *keys):
        subprocess.run([*self.tmux, "send-keys", *keys], check=True)

    def type(self, text):
        subprocess.run([*self.tmux, "send-keys", "-l", text], check=True)
        self.keys("Enter")

    def wait_for(self, pattern, seconds=60):
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            screen = self.screen()
            found = re.search(pattern, screen)
            if found:
                return found
            time.sleep(0.03)
        sys.exit(f"FAILED: {pattern!r} does not come; the screen is\n{self.screen()}")

    def end(self):
        subprocess.run([*self.tmux, "kill-server"], check=False)


class Rig:
    """The device at the port: it vibrates as the condition does."""

    def __init__(self, directory):
        self.directory, self.emulator, self.condition = directory, None, None
        with open(SCENE, encoding="utf-8") as file:
            text = file.read()
        for name, volts in VOLTS.items():
            with open(f"{directory}/{name}.toml", "w", encoding="utf-8") as scene:
                scene.write(text.replace("amplitude_v = 5", f"amplitude_v = {volts}") +
                            '\n[sensor]\nkind = "stream"\nnoise_rms_m = 0.2e-6\n')

    def mount(self, condition):
        """True where another device is there now."""
        if condition == self.condition:
            return False
        if self.emulator:
            self.emulator.end()
        programs.SCENE = f"{self.directory}/{condition}.toml"
        self.emulator = Emulator("--protocol", "stream", "--baud", "921600", "--link", f"{self.directory}/port")
        self.condition = condition
        return True


def truth_m(directory, condition):
    return json.loads(run("simulate", f"{directory}/{condition}.toml", "--json").stdout)["skin_rms_m"]


def log(folder):
    with open(f"{folder}/log.csv", encoding="utf-8", newline="") as file:
        return list(csv.DictReader(io.StringIO(file.read())))


CELL = re.compile(r"cell (\d+) of \d+ +subject (\S+), (floor|\S+, repeat \d+) +attempt (\d+)")


def next_cell(tmux):
    """Number, subject, condition and repeat of the cell on the screen; nothing where all are done."""
    found = tmux.wait_for(CELL.pattern + "|all cells are done")
    if not found[1]:
        return None
    condition, _, repeat = found[3].partition(", repeat ")
    return int(found[1]), found[2], "none" if condition == "floor" else condition, repeat or "1"


def one(tmux, rig, key, cell, mounted=None):
    """Records the cell with a key; the device is that of its condition, or another one."""
    number, subject, condition, repeat = cell
    if rig.mount(mounted or condition):
        # the loss is noticed, and the return
        time.sleep(0.3)
    name = f"subject {subject}, floor" if condition == "none" else f"subject {subject}, {condition}, repeat {repeat}"
    tmux.wait_for(": ready")
    attempts = len([line for line in log(f"{rig.directory}/day") if line["event"] == "end"])
    tmux.keys(key)
    deadline = time.monotonic() + 60
    while len([line for line in log(f"{rig.directory}/day") if line["event"] == "end"]) == attempts:
        check(time.monotonic() < deadline, f"{name} does not end:\n{tmux.screen()}")
        time.sleep(0.05)
    # the verdict and the next cell come to the screen at once
    tmux.wait_for(": ready")
    verdict = tmux.wait_for(f"(GOOD|CHECK|BAD) +{name}")[1]
    # a busy machine delays the emulated device, and the trial is cut short: recorded again, as a user would
    if verdict != "GOOD":
        one(tmux, rig, "r", cell, mounted)


def day(directory, subjects):
    folder, rig = f"{directory}/day", Rig(directory)
    rig.mount("none")
    run("session", "new", folder, "--subjects", str(subjects), "--conditions", ",".join(CONDITIONS), "--repeats", "3",
        "--seed", "7", "--floor", "per-subject", "--duration", "1s", "--expect", "tone=225Hz+-1Hz, change<5%", "--",
        "--sensor", "stream", "--port", f"{directory}/port")
    tmux, order, done = Tmux(directory, "session", "run", folder), [], 0
    try:
        while True:
            cell = next_cell(tmux)
            if cell is None:
                break
            order.append(cell)
            done += 1
            if done == 9:
                # later; it comes again behind all others
                tmux.keys("s")
                tmux.type("adapter is being glued")
                tmux.wait_for("skipped: ")
                continue
            one(tmux, rig, "Space", cell)
            if done % 20 == 0:
                one(tmux, rig, "r", cell)
            if done % 20 == 5:
                tmux.keys("x")
                tmux.type("finger slipped")
                tmux.wait_for("rejected: ")
                one(tmux, rig, "r", cell)
            if done % 20 == 11:
                # stated wrongly as the first cell's of this subject, and undone
                other = CONDITIONS[0] if cell[2] != CONDITIONS[0] else CONDITIONS[1]
                for condition, reason in ((other, "mistaken"), (cell[2], "it was right")):
                    tmux.keys("l")
                    for text in ("", condition, "", reason):
                        tmux.type(text)
                    tmux.wait_for(f"is now subject {cell[1]}, {condition}, repeat")
        tmux.keys("q")
        tmux.wait_for("trials are done")
    finally:
        tmux.end()
        rig.emulator.end()
    return folder, order


def check_day(folder, order, directory, subjects):
    status = json.loads(run("session", "status", folder, "--json").stdout)
    planned = subjects * len(CONDITIONS) * 3
    check([status[key] for key in ("planned", "good", "check", "bad")] == [planned, planned, 0, 0], status)
    check(status["floors"] == {"planned": subjects, "done": subjects} and status["next"] is None, status)
    # the order is the plan's, but for the cell that was skipped
    numbers = [cell[0] for cell in order]
    check(sorted(set(numbers)) == list(range(1, planned + subjects + 1)), numbers)
    check(numbers[:-1] == sorted(numbers[:-1]) and numbers[-1] == 9, numbers)
    # log and files agree
    begun = {line["file"] for line in log(folder) if line["event"] == "begin"}
    check(begun == set(os.listdir(f"{folder}/trials")), "each attempt has its file")
    latest = {}
    for attempt in status["attempts"]:
        latest[(attempt["subject"], attempt["condition"], attempt["repeat"])] = attempt
        header = info(f"{folder}/trials/{attempt['file']}")
        check(header["labels"]["subject"] == attempt["subject"], header)
        check(header["labels"].get("condition") == attempt["condition"], header)
    for attempt in status["attempts"]:
        counts = latest[(attempt["subject"], attempt["condition"], attempt["repeat"])] is attempt
        excluded = info(f"{folder}/trials/{attempt['file']}")["fields"].get("excluded")
        check((excluded is None) == (counts and attempt["condition"] is not None), (attempt, excluded))
    # every condition has its own truth: no trial is mislabelled
    for attempt in latest.values():
        if attempt["condition"] is None:
            continue
        trial = json.loads(run("analyze", f"{folder}/trials/{attempt['file']}", "--json").stdout)["trials"][0]
        truth = truth_m(directory, attempt["condition"])
        check(abs(trial["band_rms_m"] / truth - 1) < 0.01, f"{attempt}: {trial['band_rms_m']} for {truth} m")
    study = json.loads(run("study", folder, "--json").stdout)
    check(study["counts"]["answered"] == planned and study["missing"] == [], study["counts"])
    print(f"{len(status['attempts'])} attempts of {planned} trials and {subjects} floors, each GOOD once; "
          f"study answers {study['counts']['answered']}")


if __name__ == "__main__":
    if not shutil.which("tmux"):
        skip("tmux is not installed")
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as made:
        count = int(sys.argv[2]) if len(sys.argv) > 2 else 8
        made_folder, shown = day(made, count)
        check_day(made_folder, shown, made, count)
    print(f"passed in {time.monotonic() - began:.0f} s")
