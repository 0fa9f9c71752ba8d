"""Full disks, read-only mounts and files that exist: a clear message, nothing overwritten, nothing lost of what
was promised.

Usage: disk_test.py WRITER, a program that writes trials (tests/trial/write_trials.cc). The mounts are made in a
namespace of their own (unshare -rm); exits with 77 where that is not permitted.
"""
import os
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import DEADLINE_S, Emulator, check, program, run, skip, trial_reader

try:
    import numpy as np
except ImportError:
    skip("needs python3-numpy")

HAPTOMETER = program("haptometer")


def mounted(options, directory, script, *words):
    """Runs a shell script with a tmpfs at `directory`, in a namespace of its own."""
    mount = f'mount -t tmpfs -o {options} tmpfs "$0" && cd "$0" && {script}'
    return subprocess.run(["unshare", "-rm", "sh", "-c", mount, directory, *words],
                          capture_output=True, text=True, timeout=DEADLINE_S)


def one_line(done, *texts):
    lines = [line for line in done.stderr.splitlines() if line.startswith("haptometer ")]
    check(len(lines) == 1 and all(text in lines[0] for text in texts), f"{texts} in: {done.stderr}")
    return lines[0]


def record_until_full(directory, out):
    with Emulator("--protocol", "stream") as emulator:
        done = mounted("size=256k", directory,
                       '"$1" acquire --sensor stream --port "$2" -o t.bin --duration 50s; '
                       'status=$?; cp t.bin "$3"; exit $status', HAPTOMETER, emulator.port, out)
    check(done.returncode == 1, f"a full disk is status 1: {done.returncode} {done.stderr}")
    line = one_line(done, "t.bin", "No space left on device")
    promised = int(re.search(r"(\d+) of \d+ rows are kept", line).group(1))
    _, rows, _, closed, _ = trial_reader()(os.path.join(out, "t.bin"))
    check(not closed, "a trial that met a full disk is not called finished")
    kept = sum(len(block) for _, block in rows)
    check(kept == promised > 0, f"{promised} rows promised, {kept} kept")
    places = np.concatenate([first + np.arange(len(block)) for first, block in rows])
    check(np.array_equal(places, np.arange(kept)), "no hole among the rows that are kept")


def export_until_full(directory, trial):
    for ending, begin in {"csv": "time_s,x", "npy": "\\223NUMPY", "h5": "\\211HDF\\r\\n\\032\\n",
                          "mat": "MATLAB 5.0 MAT-file, written by haptometer"}.items():
        script = (f'printf "{begin}" > old; cp old t.$2; "$1" trial export "$3" -o t.$2 --force; status=$?; '
                  'cmp old t.$2 >&2 || status=90; ls >&2; exit $status')
        done = mounted("size=24k", directory, script, HAPTOMETER, ending, trial)
        check(done.returncode == 1, f"{ending}: {done.returncode} {done.stderr}")
        one_line(done, "t." + ending, "could not be written whole")
        check("part" not in done.stderr, f"{ending}: nothing is left behind: {done.stderr}")


def refuse_read_only(directory, trial):
    done = mounted("size=1m,ro", directory, '"$1" trial export "$2" -o t.h5', HAPTOMETER, trial)
    check(done.returncode == 1, f"read-only: {done.returncode} {done.stderr}")
    one_line(done, "t.h5")
    done = mounted("size=1m,ro", directory, '"$1" trial export "$2" -o t.csv', HAPTOMETER, trial)
    one_line(done, "t.csv", "Read-only file system")
    # the recorder asks the disk before it asks the sensor for a second reading
    done = mounted("size=1m,ro", directory, '"$1" acquire --sensor replay --port "$2" -o t.bin',
                   HAPTOMETER, trial)
    check(done.returncode == 1, f"read-only: {done.returncode} {done.stderr}")
    one_line(done, "t.bin", "Read-only file system")
    # a label cannot be added where nothing may be written
    script = 'cp "$2" t.bin; mount -o remount,ro "$0"; "$1" trial label t.bin a=b; s=$?; cmp "$2" t.bin && exit $s'
    done = mounted("size=1m", directory, script, HAPTOMETER, trial)
    check(done.returncode == 3, f"label: {done.returncode} {done.stderr}")
    one_line(done, "t.bin", "Read-only file system")


def refuse_existing(directory, trial):
    path = os.path.join(directory, "t.bin")
    open(path, "w").write("precious")
    done = run("acquire", "--sensor", "replay", "--port", trial, "-o", path, status=2)
    check(open(path).read() == "precious", "an existing trial stays")
    one_line(done, path, "already exists", "--overwrite")


def main():
    with tempfile.TemporaryDirectory() as directory:
        disk, out = os.path.join(directory, "disk"), os.path.join(directory, "out")
        os.mkdir(disk)
        os.mkdir(out)
        if mounted("size=1m", disk, "true").returncode != 0:
            skip("this system does not let users mount in a namespace of their own")
        subprocess.run([sys.argv[1], out], check=True)
        trial = os.path.join(out, "uniform.bin")
        export_until_full(disk, trial)
        refuse_read_only(disk, trial)
        refuse_existing(out, trial)
        record_until_full(disk, out)


if __name__ == "__main__":
    main()
