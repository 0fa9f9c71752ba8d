"""The programs of a build as readelf sees them: full RELRO, position-independent, stack protector, checked buffers.

Usage: hardening_test.py DIRECTORY
"""
import os
import shutil
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import check, skip


def readelf(path, *options):
    done = subprocess.run(["readelf", "--wide", *options, path], capture_output=True, text=True)
    check(done.returncode == 0, f"{path}: {done.stderr}")
    return done.stdout


def is_program(path):
    with open(path, "rb") as file:
        return file.read(4) == b"\x7fELF"


def examine(path):
    header = readelf(path, "--file-header")
    dynamic = readelf(path, "--dynamic")
    symbols = readelf(path, "--dyn-syms")
    check("DYN (Position-Independent Executable file)" in header, f"{path} has a fixed address: {header}")
    check("GNU_RELRO" in readelf(path, "--program-headers"), f"{path}: no RELRO")
    check("BIND_NOW" in dynamic and "NOW" in dynamic, f"{path}: RELRO is partial: {dynamic}")
    check("__stack_chk_fail" in symbols, f"{path}: no stack protector")
    return "_chk@" in symbols.replace("__stack_chk_fail@", "")


def main(directory):
    if shutil.which("readelf") is None:
        skip("no readelf")
    programs = [os.path.join(directory, name) for name in sorted(os.listdir(directory))]
    programs = [path for path in programs if os.path.isfile(path) and not os.path.islink(path) and is_program(path)]
    check(programs, f"no program in {directory}")
    # a program without a buffer whose size is known has nothing to check
    fortified = [os.path.basename(path) for path in programs if examine(path)]
    check("haptometer" in fortified, f"checked calls only in {fortified}")
    print(len(programs), "programs, checked calls in", len(fortified))


if __name__ == "__main__":
    main(sys.argv[1])
