"""Pictures and pages of verbs as a reader has them: quantities with units in the place of keys, numbers on every axis,
legends that leave room for the curves, and numbers before figures."""
import os
import re
import sys
import tempfile

sys.path[:0] = [os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", part) for part in ("", "golden")]
from golden import impedance  # noqa: E402
from programs import SCENE, check, run  # noqa: E402


def texts(path):
    """The texts of an SVG."""
    with open(path, encoding="utf-8") as file:
        return re.findall(r"<text[^>]*>(?:<tspan[^>]*>)?([^<]*)<", file.read().replace("\u00a0", " "))


def check_texts(path, wanted):
    found = texts(path)
    for text in wanted:
        check(text in found, f"{path} has no '{text}': {found}")


def sweep(folder):
    """A curve is named by the value of the other key with its unit."""
    run("sweep", SCENE, "--vary", "drive.frequency_hz=200:250:5", "--vary", "skin.stiffness_n_per_m=600,800",
        "-o", f"{folder}/sweep.csv", "--plot", f"{folder}/sweep.svg")
    check_texts(f"{folder}/sweep.svg", ["drive frequency / Hz", "skin RMS / µm", "skin stiffness 600 N/m"])


def impedance_fit(folder):
    """A logarithmic axis of less than a decade, 60 to 500 Hz, has more numbers than 100 and 200."""
    with open(f"{folder}/z.csv", "w", encoding="utf-8") as file:
        file.write(impedance())
    run("fit-impedance", f"{folder}/z.csv", "--moving-mass", "1.40(1)g", "--held", "--plot", f"{folder}/z.svg")
    check_texts(f"{folder}/z.svg", ["70", "150", "300", "400"])


def tune(folder):
    """The legend has three columns, so that it leaves the panel its height."""
    run("tune", "--plot", f"{folder}/tune.svg")
    check_texts(f"{folder}/tune.svg", ["skin displacement (RMS) / µm", "number relative to its optimum"])
    longest = max((text for text in texts(f"{folder}/tune.svg") if "mass" in text and "/" not in text), key=len)
    check(len(longest) < 30, longest)


def analyze(folder):
    run("analyze", "fixtures/recorded_trial.bin", "--plot", f"{folder}/trial.svg")
    found = texts(f"{folder}/trial.svg")
    check("distance, about 0 µm" in found and any("hann window" in text for text in found), found)


def reproduce(folder):
    run("reproduce", "--figures", f"{folder}/figures")
    check_texts(f"{folder}/figures/figure-3.3.svg", ["generated, not measured"])
    check_texts(f"{folder}/figures/figure-2.6.svg", ["receptors Nr"])


def simulate_page(folder):
    """The numbers stand before the figure."""
    run("simulate", SCENE, "--report", f"{folder}/simulate.html")
    with open(f"{folder}/simulate.html", encoding="utf-8") as file:
        page = file.read()
    check(0 < page.index("skin displacement (RMS)") < page.index("<figure>"), "the figure is before the numbers")


def study_page(folder):
    """The table of conditions stands before the noise floors."""
    scene = f"{folder}/scene.toml"
    with open(SCENE, encoding="utf-8") as file:
        driven = file.read() + '\n[sensor]\nkind = "stream"\nnoise_rms_m = "2um"\n'
    session = f"{folder}/day"
    for text in (driven.replace("amplitude_v = 5", "amplitude_v = 0"), driven):
        with open(scene, "w", encoding="utf-8") as file:
            file.write(text)
        if not os.path.exists(session):
            run("session", "new", session, "--subjects", "1", "--conditions", "a", "--floor", "per-subject",
                "--duration", "1s", "--", "--sensor", f"scene:{scene}", "--speed", "max")
        run("session", "next", session)
    shown = run("study", session).stdout
    check(0 < shown.index("condition  subjects") < shown.index("noise floors"), shown)


with tempfile.TemporaryDirectory() as directory:
    for part in (sweep, impedance_fit, tune, analyze, reproduce, simulate_page, study_page):
        part(directory)
