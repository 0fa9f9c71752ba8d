"""The package as Python code: interruption, threads, types, examples."""
import json
import os
import pathlib
import signal
import subprocess
import sys
import textwrap
import threading
import time

import haptometer as hm
import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = ROOT / "fixtures/lra_adapter.toml"


def run(script, **options):
    return subprocess.run([sys.executable, "-c", textwrap.dedent(script)], capture_output=True, text=True, check=False,
                          timeout=120, **options)


@pytest.mark.parametrize("call", [
    f'hm.sweep({str(SCENE)!r}, vary={{"drive.frequency_hz": (100.0, 400.0, 100_000_000)}})',
    f'hm.simulate({str(ROOT / "fixtures/lra_stops.toml")!r}, duration=5000.0)',
    f'hm.analyze_many([{str(ROOT / "fixtures/recorded_trial.bin")!r}] * 20_000)',
])
def test_ctrl_c_ends_a_verb(call):
    process = subprocess.Popen([sys.executable, "-c", textwrap.dedent(f"""
        import haptometer as hm
        print("ready", flush=True)
        try:
            {call}
        except KeyboardInterrupt:
            print("interrupted", flush=True)
        print(hm.simulate({str(SCENE)!r}).answered)
    """)], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    time.sleep(2)
    begin = time.monotonic()
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    # the next verb is not ended by the signal of the last one
    assert out == "interrupted\nTrue\n"
    assert time.monotonic() - begin < 20


def test_signals_stay_pythons():
    made = run(f"""
        import signal, haptometer as hm
        before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGPIPE)]
        hm.sweep({str(SCENE)!r}, vary={{"drive.frequency_hz": [200.0]}})
        hm.simulate({str(SCENE)!r}, duration=0.1)
        import ctypes
        assert before == [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGPIPE)]
        signal.raise_signal(signal.SIGINT)
    """)
    assert "KeyboardInterrupt" in made.stderr


@pytest.mark.parametrize("call", [f"hm.simulate({str(SCENE)!r})", "hm.bandpass(x, 1e4)",
                                  f'hm.read({str(ROOT / "fixtures/recorded_trial.bin")!r})'])
def test_interpreter_ends_beside_a_daemon_thread(call):
    made = run(f"""
        import threading, time
        import haptometer as hm, numpy as np
        x = np.random.default_rng(1).normal(0, 1, 200_000)
        def work():
            while True:
                {call}
        for _ in range(3):
            threading.Thread(target=work, daemon=True).start()
        time.sleep(1)
    """)
    assert made.returncode == 0, made.stderr


def test_ctrl_c_ends_no_verb_of_another_thread():
    made = run(f"""
        import _thread, threading, time
        import haptometer as hm
        def work():
            answers.append(hm.sweep({str(SCENE)!r}, vary={{"drive.frequency_hz": (100.0, 400.0, 20_000)}}).answered)
        answers = []
        thread = threading.Thread(target=work)
        thread.start()
        time.sleep(0.3)
        threading.Timer(0.3, _thread.interrupt_main).start()
        try:
            hm.simulate({str(SCENE)!r})
        except KeyboardInterrupt:
            print("interrupted")
        thread.join()
        print(answers)
    """)
    assert made.stdout == "interrupted\n[True]\n", made.stdout + made.stderr


def test_other_threads_run_meanwhile():
    """A thread of Python's own counts while another filters: the lock is released."""
    x = np.random.default_rng(1).normal(0, 1, 4_000_000)
    stop, count = threading.Event(), [0]

    def tick():
        while not stop.is_set():
            count[0] += 1
            time.sleep(1e-3)

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.monotonic()
    for _ in range(5):
        hm.bandpass(x, 10e3, threads=1)
    ticks, seconds = count[0], time.monotonic() - begin
    stop.set()
    thread.join()
    # 1000 a second at most; a lock that is kept would let a tick through between two calls: 5
    assert ticks > 20, seconds


def test_verbs_of_two_threads_wait_for_each_other():
    answers = []

    def work(volts):
        answers.append((volts, hm.Scene(SCENE).set("drive.amplitude_v", volts).simulate().skin_rms.value))

    threads = [threading.Thread(target=work, args=(volts,)) for volts in (1.0, 2.0, 3.0, 4.0)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    one = hm.Scene(SCENE).set("drive.amplitude_v", 1.0).simulate().skin_rms.value
    assert len(answers) == 4
    for volts, rms in answers:
        assert rms == pytest.approx(volts * one, rel=1e-12)  # linear


def test_types():
    """mypy --strict over the package and an example that uses it."""
    pytest.importorskip("mypy")
    config = ROOT / "python/pyproject.toml"
    for what in (["-p", "haptometer"], [str(ROOT / "python/examples/first_steps.py")]):
        made = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--config-file", str(config),
                               "--cache-dir", os.devnull, *what], capture_output=True, text=True, check=False)
        assert made.returncode == 0, made.stdout


def test_example(tmp_path):
    made = subprocess.run([sys.executable, ROOT / "python/examples/first_steps.py"], cwd=tmp_path, capture_output=True,
                          text=True, check=False)
    assert made.returncode == 0, made.stderr
    assert "vibration" in made.stdout


def test_notebook(tmp_path, monkeypatch):
    """The tutorial's notebook runs from its first cell to its last."""
    nbformat = pytest.importorskip("nbformat")
    execute = pytest.importorskip("nbconvert.preprocessors").ExecutePreprocessor
    # the kernel is this Python, whatever kernels are installed
    kernel = tmp_path / "jupyter/kernels/python3"
    kernel.mkdir(parents=True)
    words = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    (kernel / "kernel.json").write_text(json.dumps({"argv": words, "display_name": "Python 3", "language": "python"}))
    monkeypatch.setenv("JUPYTER_PATH", str(tmp_path / "jupyter"))
    notebook = nbformat.read(ROOT / "python/examples/tutorial.ipynb", as_version=4)
    execute(timeout=120).preprocess(notebook, {"metadata": {"path": str(tmp_path)}})
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert any("text/html" in output.get("data", {}) for output in outputs)
    assert not any(output["output_type"] == "error" for output in outputs)
