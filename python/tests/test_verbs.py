"""Verbs called from Python answer what the commands answer, bit for bit."""
import json
import os
import pathlib
import subprocess

import haptometer as hm
import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
FIXTURES = ROOT / "fixtures"
PROGRAM = pathlib.Path(os.environ.get("HAPTOMETER_PROGRAMS", ROOT / "build/release/bin")) / "haptometer"
RECORDED, SCENE, DROP = FIXTURES / "recorded_trial.bin", FIXTURES / "lra_adapter.toml", FIXTURES / "impulse.csv"


def command(*words, folder=None):
    """The JSON of a command without what is of this run."""
    made = subprocess.run([PROGRAM, *words, "--json"], capture_output=True, cwd=folder, check=False)
    document = json.loads(made.stdout)
    for name in ("utc", "command"):
        document["provenance"].pop(name)
    return document


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Trials of four subjects under two conditions."""
    folder = tmp_path_factory.mktemp("study")
    time_s = np.arange(20_000) / 10e3
    for subject in range(4):
        for number, condition in enumerate(("stock", "adapter")):
            level_m = 1e-5 * (1 + 3 * number + 0.2 * subject)
            noise = np.random.default_rng(10 * subject + number).normal(0, 1e-7, time_s.size)
            trial = hm.Trial.from_arrays(level_m * np.sin(2 * np.pi * 225 * time_s) + noise, rate=10e3,
                                         labels={"subject": str(subject), "condition": condition})
            trial.save(folder / f"{subject}_{condition}.bin")
    return folder


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    """Inputs of calibrate, matching and linearity."""
    folder = tmp_path_factory.mktemp("tables")
    pairs = "".join(f"{d},{0.5 + 2.0 * d + 1e-4 * (k % 3)}\n" for k, d in enumerate(np.linspace(-2, 2, 9)))
    (folder / "pairs.csv").write_text("displacement_mm,voltage_v\n" + pairs)
    return folder


def cases(tables):
    """Each verb: what Python says, what the command says."""
    text = str
    return {
        "analyze": (lambda: hm.analyze(RECORDED, band=(30, 400), order=4, panels=False),
                    ["analyze", text(RECORDED), "--band", "30-400Hz", "--order", "4"]),
        "calibrate": (lambda: hm.calibrate(text(tables / "pairs.csv"), panels=False),
                      ["calibrate", text(tables / "pairs.csv")]),
        "compare": (lambda: hm.compare([RECORDED, SCENE], input={"skin.stiffness_n_per_m": hm.value(600, u=50)}, panels=False),
                    ["compare", text(RECORDED), text(SCENE), "--input", "skin.stiffness_n_per_m=600+-50"]),
        "cost": (lambda: hm.cost("km", accuracy="2%", actuator="thesis-c10-100", panels=False),
                 ["cost", "km", "--accuracy", "2%", "--actuator", "thesis-c10-100"]),
        "fit-lra": (lambda: hm.fit_lra(DROP, moving_mass=hm.value(1.4e-3, u=1e-5), panels=False),
                    ["fit-lra", text(DROP), "--moving-mass", "1.4g+-0.01g"]),
        "fit-lra loads": (lambda: hm.fit_lra(open=[DROP], load={33.0: FIXTURES / "impulse_33ohm.csv"}, panels=False),
                          ["fit-lra", "--open", text(DROP), "--load", "33ohm", text(FIXTURES / "impulse_33ohm.csv")]),
        "plan-drop-test": (lambda: hm.plan_drop_test(resistance=27.0, actuator="thesis-c10-100", panels=False),
                           ["plan-drop-test", "--resistance", "27ohm", "--actuator", "thesis-c10-100"]),
        "reproduce": (lambda: hm.reproduce(), ["reproduce"]),
        "simulate": (lambda: hm.simulate(SCENE, duration=0.2), ["simulate", text(SCENE), "--duration", "0.2s"]),
        "trial info": (lambda: hm.trial_info(RECORDED, panels=False), ["trial", "info", text(RECORDED)]),
        "study matching": (lambda: hm.study_matching(FIXTURES / "matching.csv", panels=False),
                           ["study", "matching", text(FIXTURES / "matching.csv")]),
        "tune": (lambda: hm.tune(SCENE, voltage=5.0, panels=False), ["tune", text(SCENE), "--voltage", "5V"]),
    }


@pytest.mark.parametrize("name", sorted(cases(pathlib.Path())))
def test_same_numbers_as_the_command(name, tables):
    call, words = cases(tables)[name]
    assert call().to_dict() == command(*words)


def test_study_as_the_command(study):
    made = hm.study(study, panels=False)
    assert made.to_dict() == command("study", str(study))
    assert made.answered


def test_study_compare_as_the_command(study):
    """Whatever it answers: the trials are none of the scene's."""
    made = hm.study_compare(study, condition={"stock": SCENE, "adapter": SCENE}, panels=False)
    assert made.to_dict() == command("study", "compare", str(study), "--condition", f"stock={SCENE}",
                                     "--condition", f"adapter={SCENE}")


def test_sweep_has_the_table_of_the_command(tmp_path):
    made = hm.sweep(SCENE, vary={"drive.frequency_hz": (100.0, 400.0, 7)})
    command("sweep", str(SCENE), "--vary", "drive.frequency_hz=100:400:7", "-o", str(tmp_path / "t.csv"))
    rows = [line for line in (tmp_path / "t.csv").read_text().splitlines() if not line.startswith("#")]
    assert [line for line in made.table_text.splitlines() if not line.startswith("#")] == rows
    frame = made.to_pandas()
    assert list(frame["drive.frequency_hz"]) == [100, 150, 200, 250, 300, 350, 400]
    # a list of values is swept as it is
    frame = hm.sweep(SCENE, vary={"drive.frequency_hz": np.array([225.0, 110.0])}).to_pandas()
    assert list(frame["drive.frequency_hz"]) == [225, 110]


def test_analyze_many_is_a_frame(study):
    made = hm.analyze_many(study, threads=2)
    assert made.to_dict() == command("analyze", str(study))
    frame = made.to_pandas()
    assert len(frame) == 8
    one = hm.analyze(study / "0_adapter.bin")
    row = frame[frame["file"] == str(study / "0_adapter.bin")].iloc[0]
    assert row["band_rms_m"] == one.rms.value
    assert row["band_rms_m_u"] == one.rms.u


def test_arrays_give_the_number_of_their_file(study):
    path = study / "2_stock.bin"
    trial = hm.read(path)
    again = hm.Trial.from_arrays(trial["displacement"].values, rate=10e3)
    assert hm.analyze(again).rms.value == hm.analyze(path).rms.value
    # A sin(2 pi 225 t) has the RMS A / sqrt(2): within four standard uncertainties
    rms = hm.analyze(again).rms
    assert abs(rms.value - 1.4e-5 / np.sqrt(2)) < 4 * rms.u
    assert rms.interval[0] < rms.value < rms.interval[1]
    assert rms.unit == "m"


def test_scene_is_changed_in_a_copy(tmp_path):
    scene = hm.Scene(SCENE)
    changed = scene.set("drive.frequency_hz", 180.0).set("skin.stiffness_n_per_m", "1.2N/mm")
    text = SCENE.read_text()
    assert scene.text == text
    by_hand = tmp_path / "scene.toml"
    by_hand.write_text(changed.text)
    assert changed.simulate().skin_rms == hm.simulate(by_hand).skin_rms
    assert changed.simulate().skin_rms != scene.simulate().skin_rms
    # a swept key and a set key are one
    swept = scene.sweep({"drive.frequency_hz": [180.0]}).to_pandas()
    assert swept["skin_rms_m"][0] == scene.set("drive.frequency_hz", 180.0).simulate().skin_rms.value


def test_file_of_a_scene_stays_where_it_is(tmp_path):
    (tmp_path / "motor.toml").write_text(
        'moving_mass_kg = 1.4e-3\ncase_mass_kg = 6e-4\nstiffness_n_per_m = 2800\ndamping_n_s_per_m = 0.0322\n'
        'force_constant_n_per_a = 1\nresistance_ohm = 27\ninductance_h = 1.3e-4\n')
    (tmp_path / "scene.toml").write_text(
        '[actuator]\nfile = "motor.toml"\n[drive]\nkind = "sine"\namplitude_v = 5\nfrequency_hz = 225\n'
        '[skin]\nstiffness_n_per_m = 600\ndamping_n_s_per_m = 0.75\n')
    assert hm.Scene(tmp_path / "scene.toml").set("drive.amplitude_v", 4).simulate().answered


def test_waveforms_are_a_trial():
    waves = hm.Scene(SCENE).waveforms(duration=0.5, rate=20e3)
    # the last tenth of a second has whole periods of 225 Hz only nearly: half a percent
    assert np.std(waves["skin_m"].values[-2000:]) == pytest.approx(hm.simulate(SCENE).skin_rms.value, rel=5e-3)


def test_a_refusal_is_an_answer():
    made = hm.analyze(hm.Trial.from_arrays(np.zeros(50), rate=1000.0))
    assert not made.answered
    assert made.rms is None
    assert made.reasons
    assert any(finding.severity == "refusal" for finding in made.findings)


def test_wrong_use_raises_what_the_command_prints():
    for words, call in (
        (["analyze", str(RECORDED), "--band", "30-20Hz"], lambda: hm.analyze(RECORDED, band=(30, 20))),
        (["simulate", "nowhere.toml"], lambda: hm.simulate("nowhere.toml")),
        (["analyze", "nowhere.bin"], lambda: hm.analyze("nowhere.bin")),
        (["fit-lra", str(DROP), "--moving-mass", "1.4"], lambda: hm.fit_lra(DROP, moving_mass="1.4")),
    ):
        printed = subprocess.run([PROGRAM, *words], capture_output=True, text=True, check=False)
        with pytest.raises(hm.HaptometerError) as raised:
            call()
        assert str(raised.value) == printed.stderr.strip()
        assert raised.value.status == printed.returncode
    with pytest.raises(ValueError):
        hm.analyze(RECORDED, band=(30, 20))
    with pytest.raises(TypeError):
        hm.analyze(RECORDED, bnad=(20, 500))


def test_a_missing_file_among_many_warns():
    with pytest.warns(UserWarning, match="no such file"):
        made = hm.analyze_many([RECORDED, "nowhere.bin"])
    assert list(made.to_pandas()["answered"]) == [True, False]


def test_nothing_is_printed(capfd):
    hm.analyze(RECORDED)
    hm.sweep(SCENE, vary={"drive.frequency_hz": [200.0]})
    assert capfd.readouterr() == ("", "")


def test_temporary_files_are_removed(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    hm.analyze(hm.Trial.from_arrays(np.sin(np.arange(10_000.0)), rate=1e4))
    hm.sweep(hm.Scene(SCENE).set("drive.amplitude_v", 1.0), vary={"drive.frequency_hz": [200.0]})
    assert list(tmp_path.iterdir()) == []


def test_pictures_and_page():
    made = hm.analyze(RECORDED)
    figure = made.plot()
    assert len(figure.axes) == len(made._made.panels()) > 2
    page = made._repr_html_()
    assert "svg" in page and "recorded_trial.bin" in page
    assert "vibration (RMS)" in str(made)
    with pytest.raises(ValueError, match="no panels"):
        hm.analyze(RECORDED, panels=False).plot()


def test_answers_are_frozen():
    made = hm.analyze(RECORDED, panels=False)
    with pytest.raises(AttributeError):
        made.answered = False
    with pytest.raises(AttributeError):
        made.rms.value = 1.0
    with pytest.raises(AttributeError, match="there are"):
        _ = made.band_rmss
