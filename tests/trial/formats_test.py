"""Runs the Python reader of docs/formats.md, as it stands there, on files that the program wrote.

Usage: formats_test.py WRITER, a program that writes trials (tests/trial/write_trials.cc).
Exits with 77 where NumPy is missing.
"""
import os
import re
import subprocess
import sys
import tempfile

try:
    import numpy as np
except ImportError:
    print("skipped: needs python3-numpy")
    sys.exit(77)


def snippet():
    text = open("docs/formats.md", encoding="utf-8").read()
    return re.search(r"```python\n(.*?)```", text, re.S).group(1)


def main():
    namespace = {}
    exec(snippet(), namespace)
    read_trial = namespace["read_trial"]
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
    print("1 passed, 0 failed")


if __name__ == "__main__":
    main()
