"""What users get wrong is an error that names it, and changes no number in silence."""
import copy
import os
import pathlib
import subprocess

import haptometer as hm
import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
FIXTURES = ROOT / "fixtures"
RECORDED, SCENE, DROP = FIXTURES / "recorded_trial.bin", FIXTURES / "lra_adapter.toml", FIXTURES / "impulse.csv"
X = np.sin(np.arange(20_000) * 0.14)
HOLED = np.where(np.arange(20_000) == 7, np.nan, X)


@pytest.mark.parametrize("call, error, text", [
    (lambda: hm.sine_fit(X, -1e4), ValueError, "rate"),
    (lambda: hm.sine_fit(X, float("nan"), frequency=225), ValueError, "rate"),
    (lambda: hm.sine_fit(X, 1e4, frequency=5000.0), ValueError, "frequency"),
    (lambda: hm.sine_fit(X, 1e4, band=(0, 0)), ValueError, "band"),
    (lambda: hm.sine_fit(X, 1e4, noise_bandwidth=-1.0), ValueError, "bandwidth"),
    (lambda: hm.sine_fit(HOLED, 1e4), ValueError, "finite"),
    (lambda: hm.welch(X, 0), ValueError, "rate"),
    (lambda: hm.welch(HOLED, 1e4), ValueError, "finite"),
    (lambda: hm.bandpass(HOLED, 1e4), ValueError, "finite"),
    (lambda: hm.bandpass(np.ma.masked_array(X, mask=X > 0.9), 1e4), ValueError, "finite"),
    (lambda: hm.bandpass(X, 1e300), ValueError, "lower|band|rate|narrow"),
    (lambda: hm.bandpass(X, 1e6, band=(0.001, 1)), hm.UsageError, "narrow"),
    (lambda: hm.bandpass(X, 1e4, threads=100_000), ValueError, "threads"),
    (lambda: hm.read(RECORDED, rate=0), ValueError, "rate"),
    (lambda: hm.read("trial.bin\0junk"), ValueError, "null"),
    (lambda: hm.Trial.from_arrays(X, 1e4, unit="mm"), ValueError, "SI"),
    (lambda: hm.fit_lra(open=[], load={33.0: DROP}), ValueError, "--open: no file"),
    (lambda: hm.fit_lra(DROP, moving_mass=hm.fit_lra(DROP, panels=False).kv), ValueError, "in kg"),
    (lambda: hm.analyze(RECORDED, order=True), TypeError, "--order"),
    (lambda: hm.analyze(RECORDED, order=np.bool_(False)), TypeError, "--order"),
    (lambda: hm.analyze(RECORDED, floor=""), ValueError, "null|nothing|--floor"),
    (lambda: hm.analyze(RECORDED, band=(None, 500)), TypeError, "--band"),
    (lambda: hm.analyze([RECORDED, RECORDED]), hm.UsageError, "analyze_many"),
    (lambda: hm.analyze(7), TypeError, "a file is"),
    (lambda: hm.simulate(SCENE, output="-"), ValueError, "streams"),
    (lambda: hm.trial_label(hm.Trial.from_arrays(X, 1e4), {"subject": "3"}), TypeError, "path"),
    (lambda: hm.Scene(SCENE).set("skin.stiffness_n_per_m", hm.value(600, u=50)), TypeError, "uncertainties"),
    (lambda: hm.Scene(SCENE).set("drive.amplitude_v=9 #", 5), ValueError, "no key"),
    (lambda: hm.Scene(SCENE).set("drive.amplitude_v", None), TypeError, "NoneType"),
])
def test_a_mistake_is_named(call, error, text):
    with pytest.raises(error, match=text):
        call()


def test_what_was_read_is_what_is_analysed(tmp_path):
    """The number of the array, whatever the file says, is named, or has become."""
    path = tmp_path / "own.csv"
    rows = "".join(f"{k / 1e4},{1e-2 * value:.9f}\n" for k, value in enumerate(X))
    path.write_text("time_s,displacement_m\n" + rows)  # millimetres, under a wrong name
    read = hm.read(path, columns=["time_s", "displacement_mm"])
    right = hm.analyze(path, columns=["time_s", "displacement_mm"]).rms.value
    assert hm.analyze(read).rms.value == pytest.approx(right, rel=1e-12)  # by way of a file of doubles
    assert right == pytest.approx(1e-5 / np.sqrt(2), rel=1e-3)
    plain = hm.read(path)
    before = hm.analyze(plain).rms.value
    path.write_text("time_s,displacement_m\n0,0\n")
    assert hm.analyze(plain).rms.value == pytest.approx(before, rel=1e-12)


def test_a_scene_stays_as_it_was_read(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE.read_text())
    scene = hm.Scene(path)
    before = scene.simulate().skin_rms
    path.write_text(SCENE.read_text().replace("amplitude_v = ", "amplitude_v = 1"))
    assert scene.simulate().skin_rms == before


def test_a_file_named_by_set_is_looked_for_beside_the_scene(tmp_path):
    (tmp_path / "motor.toml").write_text(
        "moving_mass_kg = 1.4e-3\ncase_mass_kg = 6e-4\nstiffness_n_per_m = 2800\ndamping_n_s_per_m = 0.0322\n"
        "force_constant_n_per_a = 1\nresistance_ohm = 27\ninductance_h = 1.3e-4\n")
    (tmp_path / "scene.toml").write_text(
        "[actuator]\n[drive]\nkind = \"sine\"\namplitude_v = 5\nfrequency_hz = 225\n"
        "[skin]\nstiffness_n_per_m = 600\ndamping_n_s_per_m = 0.75\n")
    assert hm.Scene(tmp_path / "scene.toml").set("actuator.file", "motor.toml").simulate().answered


def test_channels_of_one_name_are_all_there(tmp_path):
    path = tmp_path / "two.csv"
    path.write_text("time_s,displacement_m,displacement_m\n" + "".join(f"{k},{k}e-6,{3 * k}e-6\n" for k in range(9)))
    trial = hm.read(path)
    assert trial.channels == ("displacement", "displacement_2")
    assert trial["displacement"].values[8] == 8e-6
    assert trial["displacement_2"].values[8] == 24e-6


def test_a_list_is_a_pair_where_a_pair_is_taken():
    expected = hm.analyze(RECORDED, band="20-400Hz", panels=False).rms
    for band in ((20, 400), [20, 400], np.array([20.0, 400.0]), ("20", 400)):
        assert hm.analyze(RECORDED, band=band, panels=False).rms == expected
    # no exponent, whose sign would stand for the pair's
    assert not hm.analyze(RECORDED, band=(1e-7, 500), panels=False).answered


def test_provenance_is_of_the_verb_alone():
    """Whatever else is read meanwhile."""
    import threading
    stop = threading.Event()

    def others():
        while not stop.is_set():
            hm.read(DROP)

    thread = threading.Thread(target=others)
    thread.start()
    try:
        for _ in range(30):
            inputs = hm.analyze(RECORDED, panels=False).to_dict()["provenance"]["inputs"]
            assert [os.path.basename(one["path"]) for one in inputs] == ["recorded_trial.bin"]
    finally:
        stop.set()
        thread.join()


def test_answers_are_mappings_and_can_be_copied():
    made = hm.analyze(RECORDED, panels=False)
    assert "band_rms_m" in made and len(made) == len(list(made)) > 20
    assert copy.deepcopy(made.root)["band_rms_m"] == made.rms
    assert all(isinstance(finding.subject, str) for finding in made.findings)
    assert "" not in hm.plan_drop_test(resistance=27.0, actuator="thesis-c10-100").root


def test_verbs_that_change_and_write_files(tmp_path):
    path = tmp_path / "trial.bin"
    path.write_bytes(RECORDED.read_bytes())
    hm.trial_label(path, {"subject": "-9", "condition": "stock"}, reason="typing error")
    assert hm.read(path).labels == {"subject": "-9", "condition": "stock"}
    hm.trial_exclude(path, reason="finger slipped")
    assert "finger slipped" in str(hm.trial_info(path).to_dict())
    hm.trial_include(path, reason="it had not")
    hm.trial_export(path, output=tmp_path / "trial.csv")
    assert len(hm.read(tmp_path / "trial.csv")) == 10_000
    hm.trial_plot(path, output=tmp_path / "trial.svg")
    assert (tmp_path / "trial.svg").read_text().startswith("<?xml")


def test_every_verb_is_a_function():
    """Each of them takes its words apart: a parameter that is not there is refused by the command, or by Python."""
    program = pathlib.Path(os.environ.get("HAPTOMETER_PROGRAMS", ROOT / "build/release/bin")) / "haptometer"
    help_ = subprocess.run([program, "--help"], capture_output=True, text=True, check=True).stdout
    verbs = [line.split()[0] for line in help_.splitlines() if line.startswith("  ")]
    names = {name.split("_")[0] if name.startswith(("trial_", "study_")) else name for name in hm.verbs.__all__}
    missing = {verb.replace("-", "_") for verb in verbs} - names
    assert missing == {"acquire", "campaign", "emulate", "session"}
    for name in hm.verbs.__all__:
        with pytest.raises((hm.HaptometerError, TypeError)):
            getattr(hm, name)("nowhere.bin", no_such_option=1)
