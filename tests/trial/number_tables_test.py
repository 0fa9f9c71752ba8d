"""Tables of numbers that NumPy, SciPy and h5py wrote, read by the program: each number, each time, or a refusal.

Exits with 77 where a writer is missing.
"""
import csv
import io
import os
import struct
import sys
import tempfile
import wave

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import check, run, skip

try:
    import h5py
    import numpy as np
    import scipy.io
    import scipy.io.wavfile
except ImportError as missing:
    skip(f"needs python3-numpy, python3-scipy, python3-h5py: {missing}")

ROWS = 1000
RATE = 8000
TIME = np.arange(ROWS) / RATE
MOTION = 1e-4 * np.sin(2 * np.pi * 225 * TIME) + 3e-4
VOLTS = np.cos(2 * np.pi * 225 * TIME)
AT_RATE = ("--rate", "8kHz")
NAMED = ("--columns", "time_s,displacement_m,voltage_v")


def table(path, *options):
    """The columns that the program reads, by name."""
    lines = [line for line in run("trial", "export", path, *options).stdout.splitlines() if not line.startswith("#")]
    read = list(csv.DictReader(io.StringIO("\n".join(lines))))
    return {name: [row[name] for row in read] for name in read[0]}


def numbers(texts):
    return np.array([float(text) if text else np.nan for text in texts])


def expect(path, *options, motion=MOTION, times=TIME, volts=None):
    """Values bit for bit; times to the rounding of a product."""
    read = table(path, *options)
    check(np.array_equal(numbers(read["displacement_m"]), motion, equal_nan=True), f"{path} {options}: values")
    check(np.allclose(numbers(read["time_s"]), times, rtol=0, atol=1e-15 + 4e-16 * times[-1]), f"{path}: times")
    if volts is not None:
        check(np.array_equal(numbers(read["voltage_v"]), volts), f"{path}: volts")
    return read


def refuse(path, *options, words, status=3):
    said = run("trial", "export", path, *options, status=status).stderr
    check(words in said, f"{path} {options}: {said}")


def check_npy(at):
    def save(name, array):
        np.save(at(name), array)
        return at(name)

    one = save("one.npy", MOTION)
    expect(one, *AT_RATE, "--columns", "displacement_m")
    expect(one, *AT_RATE, "--scale", "2m", motion=MOTION * 2)
    refuse(one, "--columns", "displacement_m", words="states no rate")
    for kind in ("<f4", ">f4", ">f8", "<i2", ">i4", "|u1", "<i8", "<u8"):
        scaled = (MOTION * (1 if "f" in kind else 5e5)).astype(kind)
        expect(save("kind.npy", scaled), *AT_RATE, "--columns", "displacement_m", motion=scaled.astype("f8"))
    many = np.column_stack([TIME, MOTION, VOLTS])
    for array in (many, np.asfortranarray(many), many.T, np.ascontiguousarray(many.T)):
        expect(save("many.npy", array), *NAMED, volts=VOLTS)
    refuse(save("many.npy", many), words="is a matrix of 1000 x 3 numbers without names")
    refuse(save("many.npy", many), "--columns", "time_s,displacement_m", words="without names")
    # names of fields, also with bytes between them, carry role and unit
    fields = np.zeros(ROWS, dtype=np.dtype([("flag", "u1"), ("time_ms", "f8"), ("displacement_um", "f4")], align=True))
    fields["time_ms"], fields["displacement_um"] = TIME * 1e3, MOTION * 1e6
    expect(save("fields.npy", fields), motion=fields["displacement_um"].astype("f8") * 1e-6)
    # statuses by number, as in the exports of version 0.1.0
    own = np.zeros(ROWS, dtype=[("time_s", "f8"), ("displacement_m", "f8"), ("displacement_m_status", "u1")])
    own["time_s"], own["displacement_m"], own["displacement_m_status"][7] = TIME, MOTION, 2
    over = np.where(np.arange(ROWS) == 7, np.nan, MOTION)
    check(expect(save("own.npy", own), motion=over)["status"][7] == "over", "npy: statuses")
    # of one channel its own
    two = np.zeros(ROWS, dtype=[(name, "f8") for name in ("time_s", "voltage_v", "displacement_m")]
                   + [("displacement_m_status", "u1"), ("voltage_v_status", "u1")])
    two["time_s"], two["displacement_m"], two["displacement_m_status"][7] = TIME, MOTION, 2
    check(expect(save("two.npy", two), "--channel", "displacement_m", motion=over)["status"][7] == "over", "npy: its status")
    check("status" not in table(at("two.npy"), "--channel", "voltage_v"), "npy: a status of another channel")
    own["displacement_m_status"][9] = 9
    refuse(save("own.npy", own), words="row 10 of column 'displacement_m_status' is no status")
    refuse(save("fields.npy", fields), "--rate", "9kHz", words="its times give 8000 rows per second")
    for array, words in ((MOTION.astype("c16"), "'<c16', which is no number"), (MOTION.reshape(10, 10, 10), "no table"),
                         (np.array(["a", "b"]), "'<U1', which is no number"), (np.float64(3), "no table"),
                         (np.zeros(5, dtype=[("a", "f8", 3)]), "not understood")):
        refuse(save("odd.npy", array), *AT_RATE, words=words)
    np.save(at("object.npy"), np.array([{}], dtype=object), allow_pickle=True)
    refuse(at("object.npy"), words="is a NumPy array")
    # a reading that is none, and times on no grid
    gap = MOTION.copy()
    gap[[5, 17]] = np.nan, np.inf
    read = expect(save("gap.npy", np.column_stack([TIME, gap])), "--columns", "time_s,displacement_m",
                  motion=np.where(np.isfinite(gap), gap, np.nan))
    check(read["status"][5] == read["status"][17] == "invalid", "npy: no numbers are invalid")
    jitter = TIME + np.random.default_rng(1).uniform(0, 0.4 / RATE, ROWS)
    expect(save("jitter.npy", np.column_stack([jitter, MOTION])), "--columns", "time_s,displacement_m", times=jitter)
    refuse(save("falls.npy", np.column_stack([TIME[::-1], MOTION])), "--columns", "time_s,displacement_m",
           words="before that of the row above")
    cut = open(one, "rb").read()[:-9]
    open(at("cut.npy"), "wb").write(cut)
    refuse(at("cut.npy"), *AT_RATE, words="was cut short")


def check_wav(at):
    for kind, scale in (("i2", 2**15), ("i4", 2**31), ("f4", 1)):
        sound = (VOLTS * 0.9 * scale).astype(kind)
        scipy.io.wavfile.write(at("sound.wav"), RATE, sound)
        expect(at("sound.wav"), "--scale", "2m", motion=sound.astype("f8") / scale * 2)
    scipy.io.wavfile.write(at("sound.wav"), RATE, (VOLTS * 100 + 128).astype("u1"))
    expect(at("sound.wav"), "--scale", "1m", motion=((VOLTS * 100 + 128).astype("u1").astype("f8") - 128) / 128)
    # 24 bits, which the standard library writes
    counts = (VOLTS * 0.9 * 2**23).astype("<i4")
    with wave.open(at("sound.wav"), "wb") as file:
        file.setparams((1, 3, RATE, ROWS, "NONE", ""))
        file.writeframes(b"".join(count.tobytes()[:3] for count in counts))
    expect(at("sound.wav"), "--scale", "1m", motion=counts / 2**23)
    # two tracks; a converter at its end is clipped
    sound = np.column_stack([VOLTS * 40000, VOLTS * 3]).clip(-32768, 32767).astype("i2")
    scipy.io.wavfile.write(at("two.wav"), RATE, sound)
    read = table(at("two.wav"), "--columns", "displacement_mm,-")
    clipped = np.abs(VOLTS * 40000) >= 32767
    check([status == "clipped" for status in read["status"]] == clipped.tolist(), "wav: clipped")
    refuse(at("two.wav"), "--scale", "1m", words="no column is one", status=2)
    refuse(at("two.wav"), "--columns", "displacement_m", words="names 1 columns where", status=2)
    whole = open(at("two.wav"), "rb").read()
    open(at("cut.wav"), "wb").write(whole[:-400])
    said = run("trial", "export", at("cut.wav"), "--columns", "displacement_mm,-").stderr
    check("1000" in said and "900" in said, "wav: a cut is told: " + said)
    # a program that writes to a pipe states no length, or the largest one
    head, samples = whole[:40], whole[44:]
    for length in (b"\0\0\0\0", b"\xff\xff\xff\xff"):
        open(at("piped.wav"), "wb").write(head + length + samples)
        check(table(at("piped.wav"), "--columns", "displacement_mm,-") == read, "wav: from a pipe")
    open(at("empty.wav"), "wb").write(head + b"\0\0\0\0" + b"LIST\4\0\0\0INFO")
    refuse(at("empty.wav"), words="holds 0 rows")
    open(at("odd.wav"), "wb").write(whole.replace(b"fmt \x10\0\0\0\x01", b"fmt \x10\0\0\0\x55", 1))
    refuse(at("odd.wav"), words="neither PCM")


def check_text(at):
    """UTF-16 without a byte-order mark, with characters of another script."""
    text = "Time (s),Laser (\u03bcm)\n" + "".join(f"{t:.6f},{m * 1e6:.6f}\n" for t, m in zip(TIME, MOTION))
    for encoding in ("utf-16-le", "utf-16-be", "utf-16", "utf-8"):
        open(at("text.csv"), "wb").write(text.encode(encoding))
        read = numbers(table(at("text.csv"))["displacement_m"])
        check(np.allclose(read, MOTION, rtol=0, atol=1e-12), f"{encoding}: values")


def check_mat(at):
    columns = {"time_s": TIME, "displacement_um": (MOTION * 1e6).astype("f4"), "voltage_v": VOLTS, "fs": 8000.0,
               "who": "me", "cells": np.array([1, "a"], dtype=object)}
    for form in ({"do_compression": True}, {"oned_as": "column"}, {}):
        scipy.io.savemat(at("columns.mat"), columns, **form)
        expect(at("columns.mat"), motion=columns["displacement_um"].astype("f8") * 1e-6, volts=VOLTS)
    scipy.io.savemat(at("struct.mat"), {"run": {key: columns[key] for key in ("time_s", "displacement_um")}, "n": 3})
    expect(at("struct.mat") + "/run", motion=columns["displacement_um"].astype("f8") * 1e-6)
    scipy.io.savemat(at("matrix.mat"), {"X": np.column_stack([TIME, MOTION, VOLTS])})
    expect(at("matrix.mat"), *NAMED, volts=VOLTS)
    expect(at("matrix.mat") + "/X", *NAMED, volts=VOLTS)
    refuse(at("matrix.mat"), words="without names")
    refuse(at("matrix.mat") + "/Y", words="holds no variable 'Y'")
    scipy.io.savemat(at("counts.mat"), {"displacement_mm": np.arange(ROWS, dtype="i2")})
    expect(at("counts.mat"), *AT_RATE, motion=np.arange(ROWS) * 1e-3)
    scipy.io.savemat(at("complex.mat"), {"displacement_m": MOTION + 1j})
    refuse(at("complex.mat"), *AT_RATE, words="holds no column of numbers")


def check_hdf5(at):
    path = at("any.h5")
    with h5py.File(path, "w") as file:
        file["lab/run 1/laser"] = MOTION.astype(">f4")
        file["lab/run 1/all"] = np.column_stack([TIME, MOTION, VOLTS])
        file["lab/run 1/note"] = "text"
        group = file.create_group("columns")
        group["time_s"], group["displacement_m"], group["voltage_v"] = TIME, MOTION, VOLTS
        group["fs"] = np.array([8000.0])
        rows = np.zeros(ROWS, dtype=[("time_us", "i8"), ("displacement_m", "f8"), ("word", "S3")])
        rows["time_us"], rows["displacement_m"] = np.arange(ROWS) * 125, MOTION
        file["rows"] = rows
    expect(path + "/lab/run 1/laser", *AT_RATE, "--columns", "displacement_m", motion=MOTION.astype("f4").astype("f8"))
    expect(path + "/lab/run 1/laser", *AT_RATE, "--scale", "2m", motion=MOTION.astype("f4").astype("f8") * 2)
    expect(path + "/lab/run 1/all", *NAMED, volts=VOLTS)
    expect(path + "/columns", volts=VOLTS)
    expect(path + "/rows")
    refuse(path, words="is an HDF5 file of another program")
    refuse(path + "/lab/run 1/note", words="is neither a group with columns")
    refuse(path + "/lab/run 2", words="holds no object 'lab/run 2', but the group columns")
    refuse(path + "/lab/run 1/laser", "--columns", "displacement_m", words="states no rate")
    with h5py.File(at("root.h5"), "w") as file:
        file["time_s"], file["displacement_m"] = TIME, MOTION
    expect(at("root.h5"))


def check_hdf5_of_several_files(at):
    """What lies in another file is refused before that is opened: a pipe, which an opening would wait for."""
    os.mkfifo(at("pipe"))
    np.save(at("own.npy"), np.column_stack([TIME, MOTION]))
    run("trial", "export", at("own.npy"), "--columns", "time_s,displacement_m", "-o", at("all.h5"))
    with h5py.File(at("all.h5"), "a") as file:
        for name in ("out", "own/out"):
            file[name] = h5py.ExternalLink(at("pipe"), "/x")
        file["soft"], file["near"] = h5py.SoftLink("/out"), h5py.SoftLink("/own/displacement_m")
        for name in ("raw", "group/raw"):
            file.create_dataset(name, shape=(4,), dtype="u1", external=[(at("pipe"), 0, h5py.h5f.UNLIMITED)])
        for name, most in (("virtual", (4,)), ("unlimited", (None,))):
            layout = h5py.VirtualLayout(shape=(4,), dtype="f8", maxshape=most)
            source = h5py.VirtualSource(at("pipe"), "x", shape=(4,), maxshape=most)
            rows = slice(0, 4 if most == (4,) else h5py.h5s.UNLIMITED)
            layout[rows] = source[rows]
            file.create_virtual_dataset(name, layout)
    for name in ("out", "out/x", "own/out", "soft", "soft/x", "raw", "virtual", "unlimited"):
        refuse(at("all.h5") + "/" + name, *AT_RATE, words=f"/{name}: lies in another file")
    refuse(at("all.h5") + "/group", *AT_RATE, words="all.h5/group/raw: lies in another file")
    refuse(at("all.h5") + "/none", words="holds no trial 'none', but own")
    # what lies in the file itself is read beside them
    expect(at("all.h5"))
    expect(at("all.h5") + "/near", *AT_RATE, "--columns", "displacement_m")
    for name in ("displacement_m", "header_json"):
        with h5py.File(at("all.h5"), "a") as file:
            del file["own/" + name]
            file["own/" + name] = h5py.ExternalLink(at("pipe"), "/x")
        refuse(at("all.h5"), words=f"all.h5/own/{name}: lies in another file")


def check_hdf5_of_few_bytes(at):
    """Numbers that a file states and does not hold are refused before memory is allocated for them."""
    with h5py.File(at("sparse.h5"), "w") as file:
        for name in ("a", "b", "c"):
            file.create_dataset("unwritten/" + name, shape=(2**27,), dtype="f8", chunks=(2**20,))
            file.create_dataset("few/" + name, shape=(2**27,), dtype="f8", chunks=(2**6,))[0] = 1
            file.create_dataset("begun/" + name, shape=(2**27,), dtype="f8", chunks=(2**10,))[0] = 1
        file.create_dataset("fixed", shape=(ROWS,), dtype="f8")
    for name, words in (("unwritten", "/unwritten/a: states 134217728 numbers and holds 0 bytes of them"),
                        ("few", "/few/a: states 134217728 numbers and holds 512 bytes of them"),
                        ("begun", "/begun/c: has more numbers than are read of one file"),
                        ("fixed", "/fixed: states 1000 numbers and holds 0 bytes of them")):
        refuse(at("sparse.h5") + "/" + name, *AT_RATE, words=words)
    # a constant that is compressed
    with h5py.File(at("constant.h5"), "w") as file:
        file.create_dataset("gzip", data=np.zeros(10**7, dtype="u1"), compression=9, chunks=(10**7,))
    said = run("trial", "info", at("constant.h5") + "/gzip", *AT_RATE, "--columns", "displacement_m").stdout
    check("rows          10000000" in said, "a constant: " + said)


def check_own(at):
    """An export states its columns: options of tables are refused."""
    np.save(at("own.npy"), np.column_stack([TIME, MOTION]))
    for ending in ("npy", "wav", "mat", "h5"):
        run("trial", "export", at("own.npy"), "--columns", "time_s,displacement_m", "-o", at("again." + ending))
        refuse(at("again." + ending), "--scale", "1mm", words="is for tables", status=2)
        expect(at("again." + ending))
    # statuses that are stored as signed bytes below 0
    whole = open(at("again.mat"), "rb").read()
    changed = whole.replace(struct.pack("<II", 2, ROWS) + b"\0" * ROWS, struct.pack("<II", 1, ROWS) + b"\xff" * ROWS)
    check(changed != whole, "mat: no statuses")
    open(at("signed.mat"), "wb").write(changed)
    refuse(at("signed.mat"), words="its displacement_m_status is missing, or is of another type")


def main():
    with tempfile.TemporaryDirectory() as folder:
        for part in (check_npy, check_wav, check_mat, check_hdf5, check_hdf5_of_several_files, check_hdf5_of_few_bytes,
                     check_own, check_text):
            part(lambda name: os.path.join(folder, name))


if __name__ == "__main__":
    main()
