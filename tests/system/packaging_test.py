"""The files that are installed for systemd and udev: verified by systemd-analyze, and by the keys
that udev(7) knows (udevadm of Debian 12 cannot verify rules)."""
import os
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import check, program, skip

RULES = "packaging/udev/60-haptometer.rules"

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


def unit(path):
    if shutil.which("systemd-analyze") is None:
        skip("no systemd-analyze")
    with open(path) as file:
        text = file.read()
    installed, = re.findall(r"^ExecStart=(\S+)", text, re.MULTILINE)
    check(os.path.isabs(installed) and installed.endswith("/haptometer"), installed)
    with tempfile.TemporaryDirectory() as directory:
        # the program is not installed yet
        copy = os.path.join(directory, "haptometer-acquire@rig.service")
        with open(copy, "w") as file:
            file.write(text.replace(installed, os.path.abspath(program("haptometer"))))
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


if __name__ == "__main__":
    rules()
    unit(sys.argv[1])
