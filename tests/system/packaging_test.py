"""The files that are installed for systemd and udev: verified by systemd-analyze, and by the keys
that udev(7) knows (udevadm of Debian 12 cannot verify rules). tests/package checks where they are installed."""
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import DEADLINE_S, Emulator, check, program, run, skip, wait_for

RULES = "packaging/udev/60-haptometer.rules"
UNIT = "packaging/systemd/haptometer-acquire@.service.in"
MOST_EXPOSURE = 2.5  # what the project promises

# the keys that we use, with the operators that udev(7) allows them
MATCHES = {"==", "!="}
ASSIGNS = {"=", "+=", ":="}
KEYS = {
    "ACTION": MATCHES, "KERNEL": MATCHES, "SUBSYSTEM": MATCHES, "DRIVER": MATCHES,
    "SUBSYSTEMS": MATCHES, "ENV{}": MATCHES | ASSIGNS, "ATTR{}": MATCHES | {"="},
    "GROUP": ASSIGNS, "MODE": ASSIGNS, "TAG": MATCHES | ASSIGNS, "SYMLINK": MATCHES | ASSIGNS,
    "IMPORT{}": MATCHES | {"="}, "GOTO": {"="}, "LABEL": {"="},
}
ITEM = re.compile(r'([A-Z]+)(?:\{([^}]+)\})?(==|!=|\+=|:=|=)"([^"]*)"(?:,\s*|$)')


def parse(line):
    """(key, attribute, operator, value) of each item; every byte of the line belongs to one."""
    items, at = [], 0
    while at < len(line):
        item = ITEM.match(line, at)
        check(item, f"{RULES}: {line[at:]!r} is no item")
        items.append(item.groups())
        at = item.end()
    return items


def rules():
    with open(RULES) as file:
        lines = [line.rstrip("\n") for line in file]
    parsed = [parse(line) for line in lines if line and not line.startswith("#")]
    check(len(parsed) >= 8, f"{len(parsed)} rules")
    labels, jumps = [], []
    for items in parsed:
        for key, attribute, operator, value in items:
            known = key + ("{}" if attribute else "")
            check(known in KEYS, f"{known} is no key")
            check(operator in KEYS[known], f"{key}{operator}")
            labels += [value] if key == "LABEL" else []
            jumps += [value] if key == "GOTO" else []
            check(key != "IMPORT" or attribute == "builtin", "an import that runs a program")
    check(len(labels) == 1 and set(jumps) == set(labels), f"jumps {jumps} to {labels}")
    # other devices than USB serial adapters have left before anything is set for all that remain
    sets = [any(key in ("GROUP", "MODE", "SYMLINK") for key, *_ in items) for items in parsed]
    left = [any(key == "GOTO" for key, *_ in items) for items in parsed]
    filters = [items[0][:1] + items[0][2:3] for items, leaves in zip(parsed, left) if leaves]
    check(sets.index(True) > max(i for i, leaves in enumerate(left) if leaves), "set too early")
    check(("SUBSYSTEM", "!=") in filters and ("KERNEL", "!=") in filters, f"filters {filters}")
    print(f"{len(parsed)} rules, {sum(map(len, parsed))} items")


def filled(text, directory):
    """A file of the unit that starts the program of the build."""
    check(text.count("ExecStart=@BINDIR@/haptometer ") == 1, "the unit starts something else")
    copy = os.path.join(directory, "haptometer-acquire@rig.service")
    with open(copy, "w") as file:
        file.write(text.replace("@BINDIR@", os.path.dirname(program("haptometer"))))
    return copy


def unit(path):
    if shutil.which("systemd-analyze") is None:
        skip("no systemd-analyze")
    with open(path) as file:
        text = file.read()
    with tempfile.TemporaryDirectory() as directory:
        copy = filled(text, directory)
        verified = subprocess.run(["systemd-analyze", "verify", "--man=no", "--recursive-errors=no",
                                   copy], capture_output=True, text=True)
        check(verified.returncode == 0 and verified.stderr == "",
              f"systemd-analyze: {verified.stdout}{verified.stderr}")
        # it does find mistakes
        with open(copy, "a") as file:
            file.write("[Service]\nWatchdogSecs=1\n")
        broken = subprocess.run(["systemd-analyze", "verify", "--man=no", "--recursive-errors=no",
                                 copy], capture_output=True, text=True)
        check("WatchdogSecs" in broken.stderr, "systemd-analyze sees nothing")
    print("the unit is verified")


def exposure(path):
    """What an intruder in the daemon could reach, as systemd-analyze weighs it: 10 is a program of root's."""
    with open(path) as file, tempfile.TemporaryDirectory() as directory:
        copy = filled(file.read(), directory)
        done = subprocess.run(["systemd-analyze", "security", "--offline=yes", "--no-pager", copy],
                              capture_output=True, text=True)
    found = re.search(r"Overall exposure level for \S+: ([0-9.]+)", done.stdout)
    if found is None:
        skip("systemd-analyze weighs no units that are not loaded: " + done.stderr)
    check(float(found.group(1)) <= MOST_EXPOSURE, done.stdout)
    print("exposure", found.group(1))


def system_calls(path):
    """The unit allows what the daemon calls; systemd itself cannot be started here."""
    if shutil.which("strace") is None:
        skip("no strace")
    with open(path) as file:
        text = file.read()
    groups = {}
    listed = subprocess.run(["systemd-analyze", "syscall-filter", "--no-pager"], capture_output=True, text=True)
    for line in listed.stdout.splitlines():
        word = line.strip().split()[0] if line.strip() else ""
        if line.startswith("@"):
            members = groups.setdefault(word, set())
        elif word and not word.startswith("#"):
            members.add(word)

    def spread(names):
        calls = set()
        for name in names:
            calls |= spread(groups[name]) if name.startswith("@") else {name}
        return calls

    allowed = spread(["@default"])
    for sign, names in re.findall(r"^SystemCallFilter=(~?)(.*)$", text, re.MULTILINE):
        allowed = allowed - spread(names.split()) if sign else allowed | spread(names.split())
    called = daemon_calls()
    # systemd has called execve itself
    refused = called - allowed - {"execve"}
    check(not refused, f"the unit refuses {sorted(refused)}")
    check({"openat", "ppoll", "fdatasync", "accept4"} <= called, f"the daemon was not at work: {sorted(called)}")
    print(len(called), "system calls, all allowed")


def daemon_calls():
    """What a daemon calls that records an emulated sensor, is asked, begins a new file, and is ended."""
    with tempfile.TemporaryDirectory() as directory, Emulator("--protocol", "stream", "--tcp", "127.0.0.1:0") as peer:
        config = os.path.join(directory, "rig.toml")
        trace = os.path.join(directory, "calls")
        with open(config, "w") as file:
            file.write(f'directory = "{directory}"\nsocket = "{directory}/s"\n'
                       f'[[sensor]]\nname = "left"\nport = "{peer.port}"\nsensor = "stream"\n')
        daemon = subprocess.Popen(["strace", "-f", "-qq", "-o", trace, program("haptometer"), "acquire", "--daemon", config],
                                  stderr=subprocess.PIPE)
        wait_for("the socket", lambda: os.path.exists(f"{directory}/s"))
        wait_for("a trial", lambda: any(name.endswith(".bin") for name in os.listdir(directory)))
        run("acquire", "--status", f"{directory}/s")
        children = f"/proc/{daemon.pid}/task/{daemon.pid}/children"
        with open(children) as file:
            pid = int(file.read().split()[0])
        os.kill(pid, signal.SIGHUP)
        wait_for("a second file", lambda: sum(name.endswith(".bin") for name in os.listdir(directory)) > 1)
        os.kill(pid, signal.SIGTERM)
        check(daemon.wait(DEADLINE_S) == 0, daemon.stderr.read())
        with open(trace) as file:
            return set(re.findall(r"^\d+ +([a-z_0-9]+)\(", file.read(), re.MULTILINE))


if __name__ == "__main__":
    rules()
    unit(UNIT)
    exposure(UNIT)
    system_calls(UNIT)
