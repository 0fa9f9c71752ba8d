"""Runs the readers of docs/reference/formats.md, as they stand there, on files that the program wrote: the whole one in
Python, the one in five lines of NumPy, and, asked for by a second argument, the one in Octave.

Usage: formats_test.py WRITER [octave]; WRITER is a program that writes trials (tests/trial/write_trials.cc).
Exits with 77 where NumPy or Octave is missing.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import skip, trial_reader

try:
    import numpy as np
except ImportError:
    skip("needs python3-numpy")


def snippet(language, number):
    """The document's code block of that language and number, from 0."""
    text = open("docs/reference/formats.md", encoding="utf-8").read()
    return re.findall(rf"```{language}\n(.*?)```", text, re.S)[number]


def read_in_five_lines(path, code):
    """The names that the five lines leave behind; they open trial.bin where they stand."""
    lines = [line for line in code.splitlines() if line and not line.startswith("import")]
    assert len(lines) == 5, f"{len(lines)} lines are not five"
    here, names = os.getcwd(), {}
    with tempfile.TemporaryDirectory() as directory:
        shutil.copy(path, os.path.join(directory, "trial.bin"))
        os.chdir(directory)
        try:
            exec(code, names)
        finally:
            os.chdir(here)
    return names


def check_five_lines(directory):
    code = snippet("python", 1)
    names = read_in_five_lines(os.path.join(directory, "uniform.bin"), code)
    rows, places = names["rows"], np.r_[0:500, 540:1040]
    assert np.array_equal(rows["f0"], places ** 2 - 7) and np.array_equal(rows["f1"], places / 3)
    assert np.array_equal(rows["f2"], np.float32(places) / np.float32(3))
    assert np.array_equal(rows["f3"], np.where(places % 10 == 3, 2, 0)) and not rows["f4"].any()
    rows = read_in_five_lines(os.path.join(directory, "polled.bin"), code)["rows"]
    assert np.array_equal(rows["f0"], np.arange(20) * 20_000_000)
    assert np.array_equal(rows["f1"] - rows["f0"], np.full(20, 12_000_000))
    assert np.array_equal(rows["f2"], np.arange(20))


def run_octave(path, code, more):
    """The numbers that `more` prints behind the document's code."""
    with tempfile.TemporaryDirectory() as directory:
        shutil.copy(path, os.path.join(directory, "trial.bin"))
        done = subprocess.run(["octave-cli", "--no-init-file", "--quiet", "--eval", code + more], cwd=directory,
                              capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return np.array([float(word) for word in done.stdout.split()])


def check_octave(directory):
    code = snippet("octave", 0)
    path, places = os.path.join(directory, "uniform.bin"), np.r_[0:500, 540:1040]
    for column, expected in {"value(:, 1)": places ** 2 - 7, "value(:, 2)": places / 3,
                             "value(:, 3)": np.float32(places) / np.float32(3),
                             "status(:, 1)": np.where(places % 10 == 3, 2, 0)}.items():
        assert np.array_equal(run_octave(path, code, f'printf("%.17g\\n", {column});'), expected), column
    path = os.path.join(directory, "polled.bin")
    request_ns = np.arange(20) * 20_000_000
    assert np.array_equal(run_octave(path, code, 'printf("%d\\n", time_ns(2, :));'), request_ns + 12_000_000)
    assert np.array_equal(run_octave(path, code, 'printf("%d\\n", value);'), np.arange(20))


def main():
    read_trial = trial_reader()
    with tempfile.TemporaryDirectory() as directory:
        subprocess.run([sys.argv[1], directory], check=True)
        path = os.path.join(directory, "uniform.bin")
        header, rows, events, closed, rest = read_trial(path)
        assert closed and rest == 0
        assert header["timing"] == "uniform" and header["rate_hz"] == 1000
        assert header["labels"] == {"subject": "3"} and header["averages"] == 16
        # the writer's rule: counts n*n - 7 with n on the grid, voltage n/3, 40 samples lost after 499
        assert [first for first, _ in rows] == [0, 540], [first for first, _ in rows]
        places = np.concatenate([first + np.arange(len(block)) for first, block in rows])
        block = np.concatenate([block for _, block in rows])
        assert np.array_equal(block["value0"], places.astype(np.int64) ** 2 - 7)
        assert np.array_equal(block["value1"], places / 3)
        assert np.array_equal(block["value2"], np.float32(places) / np.float32(3))
        assert np.array_equal(block["status0"], np.where(places % 10 == 3, 2, 0))
        assert not block["status1"].any()
        assert events[0]["event"] == "gap" and events[0]["row"] == 500
        assert events[-1]["labels"] == {"subject": "4"}

        header, rows, events, closed, rest = read_trial(os.path.join(directory, "polled.bin"))
        block = np.concatenate([block for _, block in rows])
        assert header["timing"] == "polled" and header["rate_hz"] is None
        assert np.array_equal(block["request_ns"], np.arange(20) * 20_000_000)
        assert np.array_equal(block["reply_ns"] - block["request_ns"], np.full(20, 12_000_000))

        # cut in the middle of the last block of rows: what came before is still read
        data = open(path, "rb").read()
        cut = os.path.join(directory, "cut.bin")
        with open(cut, "wb") as file:
            file.write(data[:int(len(data) * 0.6)])
        _, rows, _, closed, rest = read_trial(cut)
        assert not closed and rest > 0 and sum(len(block) for _, block in rows) == 500
        check_five_lines(directory)
    print("2 passed, 0 failed")


def octave_main():
    if shutil.which("octave-cli") is None:
        skip("needs octave")
    with tempfile.TemporaryDirectory() as directory:
        subprocess.run([sys.argv[1], directory], check=True)
        check_octave(directory)
    print("1 passed, 0 failed")


if __name__ == "__main__":
    octave_main() if sys.argv[2:] == ["octave"] else main()
