"""Exports read back by independent readers: h5py, scipy.io, numpy. Compared are raw bits, statuses,
times and metadata, as far as docs/reference/formats.md promises them.

Usage: export_test.py WRITER, a program that writes trials (tests/trial/write_trials.cc). Exits with
77 where a reader is missing.
"""
import json
import os
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import check, run, skip, trial_reader

try:
    import h5py
    import numpy as np
    import scipy.io
    import scipy.io.wavfile
except ImportError as missing:
    skip(f"needs python3-numpy, python3-scipy, python3-h5py: {missing}")

COLUMNS = {"uniform": ["displacement_m", "voltage_v", "channel_3"], "polled": ["displacement_m"]}


def same_bits(a, b):
    a, b = np.asarray(a), np.asarray(b)
    return a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes()


class Truth:
    """What a trial.bin holds, by the reader in the documentation."""

    def __init__(self, read_trial, path):
        self.header, blocks, self.events, self.closed, rest = read_trial(path)
        assert rest == 0
        self.raw = np.concatenate([block for _, block in blocks])
        self.index = np.concatenate([first + np.arange(len(block)) for first, block in blocks])

    def exported_events(self):
        """An export's header has the labels as last given: those as recorded come first."""
        if not any(event["event"] == "labels" for event in self.events) or not self.header["labels"]:
            return self.events
        recorded = {"event": "labels", "row": 0, "time_ns": None, "text": "as recorded", "labels": self.header["labels"]}
        return [recorded] + self.events

    def channels(self):
        return range(len(self.header["channels"]))

    def values(self, c):
        """SI values, NaN where there is no measurement."""
        form = self.header["channels"][c]
        values = self.raw[f"value{c}"].astype("f8") * form["scale"] + form["offset"]
        return np.where(self.raw[f"status{c}"] <= 1, values, np.nan)

    def statuses(self, c):
        return self.raw[f"status{c}"]


def check_table(truth, name, columns, table, what):
    """`table[column]`: values and statuses of every channel, bit for bit."""
    for c in truth.channels():
        values = np.asarray(table[columns[c]]).ravel()
        bad = truth.statuses(c) > 1
        check(same_bits(values[~bad], truth.values(c)[~bad]), f"{what}: {name} {columns[c]} values")
        check(np.isnan(values[bad]).all(), f"{what}: {name} {columns[c]} is NaN where bad")
        statuses = np.asarray(table[columns[c] + "_status"]).ravel()
        check(same_bits(statuses, truth.statuses(c)), f"{what}: {name} {columns[c]} statuses")


def check_header(truth, text, what):
    header = json.loads(text)
    labels = dict(truth.header["labels"])
    for event in truth.events:
        labels.update(event.get("labels", {}))
    check(header["labels"] == labels, f"{what}: labels as last given")
    for key in ("source", "sensor", "averages", "timing", "fields", "notes", "tare_m"):
        check(header[key] == truth.header[key], f"{what}: {key}")
    for ours, theirs in zip(header["channels"], truth.header["channels"]):
        for key in ("name", "role", "unit", "range_min", "range_max", "resolution"):
            check(ours[key] == theirs[key], f"{what}: channel's {key}")
    return header


def check_hdf5(truths, path):
    with h5py.File(path, "r") as file:
        check(sorted(file) == sorted(truths), f"groups {list(file)}")
        for name, truth in truths.items():
            group = file[name]
            check_table(truth, name, COLUMNS[name], group, "hdf5")
            header = check_header(truth, group["header_json"][()], "hdf5")
            check(header["channels"] == truth.header["channels"], "hdf5: scale and encoding")
            raw = group["raw"]
            for c in truth.channels():
                check(same_bits(raw[COLUMNS[name][c]][:], truth.raw[f"value{c}"]), "hdf5: raw bits")
            if name == "uniform":
                check(same_bits(raw["index"][:], truth.index), "hdf5: places on the grid")
                # the grid itself: start of the stretch + row / rate
                expected = np.concatenate([np.arange(500) / 1000, 0.54 + np.arange(500) / 1000])
                check(same_bits(group["time_s"][:], expected), "hdf5: times")
            else:
                for key in ("request_ns", "reply_ns"):
                    check(same_bits(raw[key][:], np.ascontiguousarray(truth.raw[key])), "hdf5: " + key)
                middle = 0.5 * (truth.raw["request_ns"] * 1e-9 + truth.raw["reply_ns"] * 1e-9)
                check(np.allclose(group["arrival_s"][:], middle, rtol=0, atol=1e-15),
                      "hdf5: raw times, one rounding")
            events = [json.loads(line) for line in group["events_json"][()].splitlines()]
            check(events == truth.exported_events(), "hdf5: events")
            check(group.attrs["closed"] == 1, "hdf5: closed")


def check_former_hdf5(path, directory):
    """The name of the times of arrival in version 0.1.0."""
    former = os.path.join(directory, "former.h5")
    shutil.copy(path, former)
    with h5py.File(former, "a") as file:
        file.move("polled/arrival_s", "polled/raw_time_s")
    read = [run("trial", "export", one + "/polled").stdout for one in (path, former)]
    check(read[0] == read[1] and "arrival_s" in read[0], "hdf5: raw_time_s is read")


def check_mat(truths, path):
    file = scipy.io.loadmat(path, simplify_cells=True)
    for name, truth in truths.items():
        check_table(truth, name, COLUMNS[name], file[name], "mat")
        check_header(truth, file[name]["header_json"], "mat")
        text = file[name]["events_json"]  # an empty one comes as an array
        events = [json.loads(line) for line in text.splitlines()] if len(text) else []
        check(events == truth.exported_events(), "mat: events")
        check(file[name]["closed"] == 1, "mat: closed")
    middle = 0.5 * (truths["polled"].raw["request_ns"] * 1e-9 + truths["polled"].raw["reply_ns"] * 1e-9)
    check(np.allclose(file["polled"]["arrival_s"], middle, rtol=0, atol=1e-15), "mat: times of arrival")
    check(file["uniform"]["time_s"][-1] == 0.54 + 499 / 1000, "mat: times")
    check(file["uniform"]["stretches"].tolist()
          == [[0, 500, 0, 1000, 0], [500, 500, 0.54, 1000, 0]], "mat: stretches")


def check_npy(truths, directory):
    for name, truth in truths.items():
        path = os.path.join(directory, name + ".npy")
        run("trial", "export", os.path.join(directory, name + ".bin"), "-o", path)
        table = np.load(path)
        check_table(truth, name, COLUMNS[name], table, "npy")
        check(len(table) == len(truth.raw), "npy: rows")
        check(("arrival_s" in table.dtype.names) == (name == "polled"), "npy: times of arrival")
        with open(path, "rb") as file:
            np.load(file)
            description = json.loads(np.load(file).item())
        check_header(truth, json.dumps(description["header"]), "npy")
        check(description["events"] == truth.exported_events() and description["closed"], "npy: events")
    # more columns than the short form of the header has room for
    wide = os.path.join(directory, "wide.csv")
    with open(wide, "w") as file:
        file.write("time_s," + ",".join(f"c{i}" for i in range(1300)) + "\n")
        for row in range(3):
            file.write(f"{row}," + ",".join(str(row + i) for i in range(1300)) + "\n")
    run("trial", "export", wide, "-o", os.path.join(directory, "wide.npy"))
    table = np.load(os.path.join(directory, "wide.npy"), allow_pickle=True)  # lifts a size limit
    check(table["channel_1000"].tolist() == [999, 1000, 1001], "npy: version 2 header")


def check_wav(directory):
    source = os.path.join(directory, "tone.csv")
    path = os.path.join(directory, "tone.wav")
    truth = 0.03 + 1e-5 * np.sin(2 * np.pi * 225 * np.arange(1000) / 8000)
    with open(source, "w") as file:
        file.write("time_s,displacement_m,voltage_v\n")
        for n, value in enumerate(truth):
            file.write(f"{n / 8000!r},{value!r},{n}\n")
    done = run("trial", "export", source, "-o", path)
    rate, samples = scipy.io.wavfile.read(path)
    check(rate == 8000 and samples.dtype == np.float64 and samples.shape == (1000, 2), "wav: form")
    said = done.stderr
    check("offset removed" in said and said.split(": ", 1)[1].strip().encode() in open(path, "rb").read(),
          "wav: the offset is said and stands in the file: " + said)
    offset = float(said.split("displacement_m = sample + ")[1].split(";")[0])
    check(abs(offset - truth.mean()) < 1e-15, "wav: the offset is the mean")
    # differences within a factor of two are exact (Sterbenz)
    check(same_bits(samples[:, 0] + offset, truth), "wav: sample + offset")
    for name, text in {"gap": "time_s,voltage_v\n" + "".join(
                           f"{n / 100},1\n" for n in range(50) if n != 20),
                       "bad": "time_s,voltage_v\n" + "".join(
                           f"{n / 100},{'' if n == 20 else 1}\n" for n in range(50)),
                       "third": "time_s,voltage_v\n" + "".join(
                           f"{n / 33.5!r},1\n" for n in range(50))}.items():
        bad = os.path.join(directory, name + ".csv")
        open(bad, "w").write(text)
        refused = os.path.join(directory, name + ".wav")
        run("trial", "export", bad, "-o", refused, status=3)
        check(not os.path.exists(refused), "wav: a refused file is not left behind")


def check_refusals(directory):
    target = os.path.join(directory, "precious.h5")
    trial = os.path.join(directory, "uniform.bin")
    for ending in ("h5", "mat", "npy", "csv"):
        target = os.path.join(directory, "precious." + ending)
        open(target, "w").write("precious")
        done = run("trial", "export", trial, "-o", target, status=2)
        check("already exists" in done.stderr and open(target).read() == "precious", ending)
        done = run("trial", "export", trial, "-o", target, "--force", status=2)
        check("exists and is not" in done.stderr and open(target).read() == "precious", ending)
        os.remove(target)
        run("trial", "export", trial, "-o", target)
        older = os.stat(target)
        run("trial", "export", trial, "-o", target, "--force")
        check(os.stat(target).st_ino != older.st_ino and os.stat(target).st_size == older.st_size, ending)
    run("trial", "export", trial, trial, "-o", os.path.join(directory, "two.npy"), status=2)
    # of a folder with a broken file the others are exported
    broken = os.path.join(directory, "sub")
    os.mkdir(broken)
    open(os.path.join(broken, "a.bin"), "wb").write(open(trial, "rb").read())
    open(os.path.join(broken, "b.bin"), "wb").write(b"\x00\x01")
    run("trial", "export", broken, "-o", os.path.join(broken, "all.h5"), status=3)
    check(sorted(h5py.File(os.path.join(broken, "all.h5"))) == ["a"], "the others are exported")
    check(not [name for name in os.listdir(broken) if "part" in name], "nothing is left behind")


def main():
    read_trial = trial_reader()
    with tempfile.TemporaryDirectory() as directory:
        subprocess.run([sys.argv[1], directory], check=True)
        trials = {name: os.path.join(directory, name + ".bin") for name in COLUMNS}
        truths = {name: Truth(read_trial, path) for name, path in trials.items()}
        whole = os.path.join(directory, "all.h5")
        run("trial", "export", directory, "-o", whole)
        check_hdf5(truths, whole)
        check_former_hdf5(whole, directory)
        run("trial", "export", *trials.values(), "-o", os.path.join(directory, "all.mat"))
        check_mat(truths, os.path.join(directory, "all.mat"))
        check_npy(truths, directory)
        check_wav(directory)
        check_refusals(directory)


if __name__ == "__main__":
    main()
