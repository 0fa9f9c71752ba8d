"""Recordings as arrays, and their signals."""
import pathlib
import subprocess
import sys
import textwrap

import haptometer as hm
import numpy as np
import pytest
import scipy.signal

FIXTURES = pathlib.Path(__file__).resolve().parents[2] / "fixtures"


def test_values_are_views_that_cannot_be_written():
    trial = hm.read(FIXTURES / "recorded_trial.bin")
    one, other = trial["displacement"].values, trial["displacement"].values
    assert one.__array_interface__["data"][0] == other.__array_interface__["data"][0]
    assert not one.flags.writeable and not trial.time.flags.writeable
    with pytest.raises(ValueError):
        one[0] = 0.0
    # they outlive the trial
    del trial
    assert np.isfinite(one).all()


def test_time_and_segments():
    trial = hm.read(FIXTURES / "recorded_trial.bin")
    (segment,) = trial.segments
    expected = segment.start_s + np.arange(segment.rows) / segment.rate_hz
    assert np.array_equal(trial.time, expected)
    assert len(trial) == len(trial.time) == 10_000
    assert trial.labels == {"subject": "demo"}
    assert trial.metadata["sensor"]


@pytest.mark.parametrize("rows", [10_000_000])
def test_reading_takes_no_second_copy(tmp_path, rows):
    """Peak memory of reading below 1.3 times the values."""
    path = tmp_path / "long.bin"
    hm.Trial.from_arrays(np.sin(np.arange(rows) * 0.14), rate=10e3).save(path)
    script = textwrap.dedent(f"""
        import pathlib, re
        import haptometer
        def kilobytes(name):
            return int(re.search(name + r":\\s+(\\d+)", pathlib.Path("/proc/self/status").read_text())[1])
        before = kilobytes("VmRSS")
        values = haptometer.read({str(path)!r})["displacement"].values
        print(1024 * (kilobytes("VmHWM") - before) / values.nbytes)
    """)
    made = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    # 1 of values and 1/8 of statuses are kept
    assert 1.1 < float(made.stdout) < 1.3


def test_from_arrays_keeps_every_bit(tmp_path):
    x = np.random.default_rng(1).normal(0, 1e-5, 1000)
    x[[3, 500]] = np.nan
    trial = hm.Trial.from_arrays({"displacement": x, "drive": np.cos(np.arange(1000.0))}, rate=2000.0, unit=["m", "V"],
                                 labels={"subject": "7", "condition": "stock"})
    trial.save(tmp_path / "t.bin")
    again = hm.read(tmp_path / "t.bin")
    assert again.channels == ("displacement", "drive")
    assert again["voltage"].name == "drive"
    good = np.isfinite(x)
    assert np.array_equal(again["displacement"].values[good], x[good])
    assert list(np.flatnonzero(again["displacement"].status != 0)) == [3, 500]
    assert hm.STATUSES[again["displacement"].status[3]] == "invalid"
    assert again.labels == {"subject": "7", "condition": "stock"}
    assert list(again.to_pandas().columns) == ["displacement", "drive"]
    with pytest.raises(hm.UsageError, match="exists"):
        trial.save(tmp_path / "t.bin")


@pytest.mark.parametrize("wrong", [
    lambda: hm.Trial.from_arrays([], rate=1.0),
    lambda: hm.Trial.from_arrays([[1.0]], rate=1.0),
    lambda: hm.Trial.from_arrays([1.0], rate=0.0),
    lambda: hm.Trial.from_arrays({"a": [1.0], "b": [1.0, 2.0]}, rate=1.0),
    lambda: hm.Trial.from_arrays([1.0], rate=1.0, unit=["m", "V"]),
    lambda: hm.bandpass([1.0, 2.0], rate=1e3, band=(20, 600)),
    lambda: hm.bandpass([[1.0, 2.0]], rate=1e4),
    lambda: hm.bandpass([1.0, 2.0], rate=1e4, corner="none"),
    lambda: hm.bandpass([1.0, 2.0], rate=1e4, threads=0),
    lambda: hm.welch([1.0, 2.0], rate=1e4, window="none"),
    lambda: hm.welch([1.0, 2.0], rate=1e4, segment_size=3),
])
def test_wrong_values_are_errors(wrong):
    with pytest.raises(ValueError):
        wrong()


def test_bandpass_against_scipy():
    """SciPy's sosfiltfilt of a Butterworth whose two passes have -3 dB at the corners, away from the ends."""
    rate, order = 10e3, 4
    x = np.random.default_rng(2).normal(0, 1, 40_000)
    # the corners widened as both passes together need: bw / (sqrt(2) - 1)^(1/(2 N)) about the same centre
    low, high = np.tan(np.pi * np.array([20, 500]) / rate)
    width = (high - low) / (np.sqrt(2) - 1) ** (1 / (2 * order))
    half = np.sqrt(width**2 / 4 + low * high)
    corners = np.arctan([half - width / 2, half + width / 2]) * rate / np.pi
    sos = scipy.signal.butter(order, corners, "bandpass", fs=rate, output="sos")
    theirs = scipy.signal.sosfiltfilt(sos, x)
    ours = hm.bandpass(x, rate, (20, 500), order=order)
    # SciPy's direct form loses 1e-11 of the signal at 20 Hz of 10 kHz
    assert np.max(np.abs(ours - theirs)[8000:-8000]) < 1e-9 * np.max(np.abs(x))
    # a view, a list and a strided array are the same numbers
    assert np.array_equal(hm.bandpass(list(x), rate, order=order), ours)
    assert np.array_equal(hm.bandpass(np.repeat(x, 2)[::2], rate, order=order), ours)
    assert np.array_equal(hm.bandpass(x, rate, order=order, threads=1), ours)


def test_welch_against_scipy():
    x = np.random.default_rng(3).normal(0, 1, 50_000)
    ours = hm.welch(x, 10e3, segment_size=1000)
    frequency, theirs = scipy.signal.welch(x, 10e3, "hann", 1000, detrend="constant")
    # bin 0 of both is what the subtracted mean leaves
    np.testing.assert_allclose(ours.density[1:], theirs[1:], rtol=1e-12)
    np.testing.assert_allclose(ours.frequency_hz, frequency, rtol=1e-15)


def test_sine_fit():
    rate, n = 10e3, 20_000
    noise = np.random.default_rng(4).normal(0, 0.01, n)
    x = 0.7 * np.cos(2 * np.pi * 225.3 * np.arange(n) / rate + 0.4) + noise
    fit = hm.sine_fit(x, rate)
    for found, truth in ((fit.frequency, 225.3), (fit.amplitude, 0.7), (fit.phase, 0.4)):
        assert abs(found.value - truth) < 5 * found.u  # once in two million
    known = hm.sine_fit(x, rate, frequency=225.3)
    assert known.amplitude.value == pytest.approx(fit.amplitude.value, rel=1e-3)
    assert hm.sine_fit(noise, rate) is None
