"""Samples that NumPy writes into acquire's standard input, read back by the reader of docs/reference/formats.md;
replays, scenes and lists through the real program. Exits with 77 where NumPy is missing."""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import DEADLINE_S, SCENE, Emulator, program, run, skip, trial_reader

try:
    import numpy as np
except ImportError:
    skip("needs python3-numpy")

FORMATS = pathlib.Path("docs/reference/formats.md").read_text(encoding="utf-8")
read_trial = trial_reader()


def rows_of(path):
    header, blocks, events, closed, left = read_trial(path)
    assert closed and left == 0
    index = np.concatenate([first + np.arange(len(block)) for first, block in blocks])
    assert (index == np.arange(len(index))).all()
    return header, np.concatenate([block for _, block in blocks]), events


def pipe(directory, name, data, options, status=0):
    path = os.path.join(directory, name + ".bin")
    done = run("acquire", "--sensor", "pipe", "--json", "-o", path, *options, data=data,
               status=status)
    return path, json.loads(done.stdout) if status == 0 else done.stderr


def test_every_form_arrives_bit_for_bit(directory):
    rng = np.random.default_rng(1)
    values = rng.standard_normal((20000, 2)) * [1e-3, 5]
    values[7, 0] = np.nan
    values[9, 1] = np.inf
    channels = ["--rate", "200kHz", "--channels", "displacement:m,voltage:V"]
    text = "".join(f"{a!r},{b!r}\n" for a, b in values.tolist()).encode()
    for form, data, kept in [("f64", values.astype("<f8").tobytes(), values),
                             ("f32", values.astype("<f4").tobytes(), values.astype("<f4")),
                             ("text", text, values)]:
        path, summary = pipe(directory, form, data, ["--format", form, *channels])
        assert summary["readings"] == 20000 and summary["bad"] == 2, summary
        header, rows, _ = rows_of(path)
        assert header["timing"] == "uniform" and header["rate_hz"] == 200e3
        for i in range(2):
            assert (rows[f"value{i}"].tobytes() == kept[:, i].astype(rows[f"value{i}"].dtype).tobytes())
        assert rows["status0"][7] == 4 and rows["status1"][9] == 4
        assert (rows["status0"] != 0).sum() == 1 and (rows["status1"] != 0).sum() == 1


def test_counts_with_a_calibration(directory):
    calibration = os.path.join(directory, "il030.toml")
    # the example as it stands there
    pathlib.Path(calibration).write_text(re.search(r"```toml\n(.*?)```", FORMATS, re.S).group(1))
    counts = np.array([[0, 1], [16384, 0], [17300, 0], [32767, 1], [-32768, 0]], "<i2")
    path, summary = pipe(directory, "i16", counts.tobytes(),
                         ["--format", "i16", "--rate", "10kHz", "--channels", "displacement,trigger",
                          "--calibration", calibration])
    header, rows, _ = rows_of(path)
    channel = header["channels"][0]
    # 20 V over 65536 counts and 1 mm a volt: 16384 counts are 5 mm; 17300 counts are 5.28 V
    np.testing.assert_allclose(rows["value0"] * channel["scale"] + channel["offset"],
                               counts[:, 0] * (20 / 65536) * 1e-3, rtol=1e-14)
    assert rows["status0"].tolist() == [0, 0, 4, 7, 7]
    assert header["fields"]["calibration"] == "IL-030, rig 2"
    assert "bad" in summary and summary["bad_by_kind"]["clipped"] == 2


def test_a_cut_row_at_the_end_is_counted(directory):
    options = ["--format", "f64", "--rate", "1kHz", "--channels", "voltage:V,current:A"]
    path, summary = pipe(directory, "cut", np.arange(20.0).tobytes() + b"abcde", options)
    assert summary["readings"] == 10 and summary["discarded_bytes"] == 5
    assert rows_of(path)[1]["value1"].tolist() == list(range(1, 20, 2))
    # nothing but a part of a row
    _, said = pipe(directory, "nothing", b"abc", options, status=3)
    assert "ended before a whole row came" in said and not os.path.exists(directory + "/nothing.bin")


def test_any_pieces_give_the_same_rows(directory):
    data = np.arange(300.0).tobytes()
    path = os.path.join(directory, "pieces.bin")
    acquire = subprocess.Popen([program("acquire"), "--sensor", "pipe", "--format", "f64", "--rate", "1kHz",
                                "--channels", "a,b,c", "-o", path], stdin=subprocess.PIPE,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        for at in range(0, len(data), 7):
            acquire.stdin.write(data[at:at + 7])
            acquire.stdin.flush()
        acquire.stdin.close()
        assert acquire.wait(DEADLINE_S) == 0
    finally:
        acquire.kill()
    assert rows_of(path)[1]["value2"].tolist() == list(range(2, 300, 3))


def live(directory, name, options):
    """Two columns at 5000 rows/s by the clock, in blocks of 50 ms, into acquire."""
    path = os.path.join(directory, name + ".bin")
    acquire = subprocess.Popen([program("acquire"), "--sensor", "pipe", "--format", "f64", "--json", "-o", path,
                                *options], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    begin = time.monotonic()
    try:
        for block in range(36):
            acquire.stdin.write(np.zeros((250, 2)).tobytes())
            acquire.stdin.flush()
            time.sleep(max(0, begin + 0.05 * (block + 1) - time.monotonic()))
    except BrokenPipeError:
        pass
    # closes standard input too
    out, _ = acquire.communicate(timeout=DEADLINE_S)
    assert acquire.returncode == 0, acquire.returncode
    doubts = [found for found in json.loads(out)["findings"] if found["severity"] == "doubt"]
    remarks = [event["text"] for event in rows_of(path)[2] if event["text"].startswith("doubt: rows came at ")]
    assert len(doubts) == len(remarks), (doubts, remarks)
    return doubts


def test_another_rate_than_the_stated_one_is_a_doubt(directory):
    both = ["--channels", "displacement:um,voltage:V"]
    for options, rate_hz in [(["--rate", "10kHz", *both], 5e3),
                             (["--rate", "5kHz", "--channels", "displacement:um"], 10e3)]:
        [doubt] = live(directory, f"other_{rate_hz:g}", options)
        assert doubt["kind"] == "row-rate-differs", doubt
        # spans of 0.25 s on a machine with other work
        assert abs(doubt["numbers"]["rate_hz"] / rate_hz - 1) < 0.1, doubt
    assert live(directory, "as_stated", ["--rate", "5kHz", *both]) == []


def test_a_replay_takes_its_time_and_gives_the_same_rows(directory):
    first, _ = pipe(directory, "first", np.sin(np.arange(500)).tobytes(),
                    ["--format", "f64", "--rate", "1kHz", "--channels", "displacement:mm"])
    for speed, least_s in [("recorded", 0.499), ("max", 0), ("4", 0.12)]:
        again = os.path.join(directory, f"again_{speed}.bin")
        begin = time.monotonic()
        run("acquire", "--sensor", "replay", "--port", first, "--speed", speed, "-o", again)
        assert time.monotonic() - begin >= least_s
        header, rows, _ = rows_of(again)
        assert (rows == rows_of(first)[1]).all()
        assert header["source"].startswith("replay of ")


def test_a_scene_is_recorded_as_it_is_simulated(directory):
    simulated = os.path.join(directory, "simulated.bin")
    run("simulate", SCENE, "--duration", "0.2s", "-o", simulated)
    recorded = os.path.join(directory, "recorded.bin")
    run("acquire", "--sensor", "scene:" + SCENE, "--samples", "2000", "--speed", "max", "-o", recorded)
    header, rows, _ = rows_of(recorded)
    assert header["source"].startswith("simulated") and header["fields"]["scene"] == SCENE
    assert len(rows) == 2000
    # `simulate --duration` starts from rest, the scene without a duration is steady: not compared row
    # by row; the steady RMS is that of the closed form (tests/sim/linear/steady_state_test.cc)
    values = rows["value0"][:2000 - 2000 % 400] * header["channels"][0]["scale"]
    assert abs(np.sqrt(np.mean((values - values.mean()) ** 2)) / 0.2001762058e-3 - 1) < 1e-3
    assert rows_of(simulated)[0]["channels"] == header["channels"]


def test_numbered_lines_that_are_lost_are_gaps(directory):
    form = "000,+00.0000,mm,CR"
    path = os.path.join(directory, "numbered.bin")
    with Emulator("--protocol", "stream", "--format", form, "--sampling", "1ms", "--fault",
                  "silent:100") as emulator:
        done = run("acquire", "--sensor", "stream", "--format", form, "--port", emulator.port, "--json",
                   "--samples", "1000", "-o", path)
    header, rows, events = rows_of(path)
    gaps = [event for event in events if event["event"] == "gap"]
    # one line in a hundred is left out; a machine that stalls may lose more, never fewer
    assert len(rows) == 1000 and len(gaps) >= 9, len(gaps)
    assert json.loads(done.stdout)["gaps"] >= len(gaps)
    assert all(event["text"].startswith("readings lost here, by the sensor's own count: ")
               for event in gaps)


def test_lists_are_documents(directory):
    sensors = json.loads(run("acquire", "--list-sensors", "--band", "20-500Hz", "--resolution", "1um",
                             "--json").stdout)
    assert sensors["band_hz"] == [20, 500]
    answers = [sensor["can_answer"] for sensor in sensors["sensors"]]
    assert any(answers) and not all(answers) and answers == sorted(answers, reverse=True)
    assert isinstance(json.loads(run("acquire", "--list-ports", "--json").stdout)["ports"], list)
    assert "cannot" in run("acquire", "--list-sensors").stdout


def test_wrong_options_are_told_in_one_line(directory):
    for options, words in [
            (["--sensor", "pipe"], "--channels: is missing"),
            (["--sensor", "pipe", "--channels", "a"], "--rate: is missing"),
            (["--sensor", "pipe", "--channels", "a", "--rate", "1kHz"], "--format: is missing"),
            (["--sensor", "pipe", "--channels", "a", "--rate", "1kHz", "--format", "f16"], "f16"),
            (["--sensor", "stream", "--port", "x", "--rate", "1kHz"], "--rate: is for samples"),
            (["--sensor", "stream", "--port", "x", "--speed", "max"], "--speed: is for what is played"),
            (["--sensor", "scene:" + SCENE, "--port", "x"], "--port: a scene has none"),
            (["--sensor", "strem", "--port", "x"], "'strem' is not known"),
            (["--list-sensors", "--band", "500-20Hz"], "does not rise")]:
        said = run("acquire", *options, "-o", os.path.join(directory, "no.bin"), status=2).stderr
        assert words in said and said.count("\n") == 1, said


with tempfile.TemporaryDirectory() as scratch:
    for name, test in list(globals().items()):
        if name.startswith("test_"):
            test(scratch)
            print("ok", name)
