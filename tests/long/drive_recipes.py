"""Records that an earlier version answered wrongly or refused without reason.

Seed 0 of each is one exact recipe; seeds 1 to 5 draw other parameters of the same kind.
"""
import numpy as np
from scipy.signal import chirp, lfilter

from drive_catalog import add_beat, blank, without_rows
from drive_record import Record
from drive_scene import Scene, gate, log_uniform

RECIPES = {}


def recipe(name):
    """A recipe; one of a number was answered wrongly, and may be refused."""
    def add(make):
        def record(rng, seed):
            def pick(exact, *drawn):  # the recipe's number, or one from a range
                if seed == 0:
                    return exact
                low, high = drawn or (0.7 * exact, 1.4 * exact)
                return rng.uniform(low, high)
            made = make(rng, pick)
            made.must_answer = not name[0].isdigit()
            return made
        RECIPES["recipe-" + name] = record
        return make
    return add


def scene_of(rng, pick, rate, length, amplitude, frequency, noise=None):
    # noise 0 in the exact recipe unless it states one, some nanometres in the others;
    # the frequency stays below the corner, and the length above two seconds
    noise = pick(0.0, 1e-9, 50e-9) if noise is None else noise
    return Scene(rng, round(pick(rate)), pick(length, max(2.0, 0.7 * length), 1.4 * length),
                 min(pick(frequency), 450.0), pick(amplitude), noise)


def drifting(rng, pick, length, rate_hz_per_s):
    scene = scene_of(rng, pick, 5000, length, 100e-6, 150)
    slope = pick(rate_hz_per_s, 0.2, 4)
    track = ([0.0, scene.length_s],
             [scene.frequency_hz, scene.frequency_hz + slope * scene.length_s])
    return scene.tone(frequency=track, phase=0.0).record(0.0)


@recipe("1a")
def linear_drift(rng, pick):
    return drifting(rng, pick, 3.0, 2.0)


@recipe("1b")
def slower_drift(rng, pick):
    return drifting(rng, pick, 5.0, 1.2)


@recipe("1c")
def random_drift(rng, pick):
    scene = Scene(rng, 5000, rng.uniform(2, 8), amplitude_m=100e-6, noise_m=0.0)
    return scene.tone(frequency=scene.walk(rng.uniform(1, 8))).record()


def off_in_the_middle(scene, pick, off, back):
    off, back = pick(off, 0.8 * off, 1.2 * off), pick(back, 0.9 * back, 1.1 * back)
    on = [(-1.0, off), (back, scene.length_s + 1)]
    return scene.tone(gate(scene.amplitude_m, *on), phase=0.0).with_fields(
        oracle_s=max((0.0, off), (back, scene.length_s), key=lambda p: p[1] - p[0])).record(0.0)


@recipe("2a")
def quiet_middle(rng, pick):
    scene = scene_of(rng, pick, 5000, 2.0, 50e-6, 200)
    return off_in_the_middle(scene, pick, 0.2 * scene.length_s, 0.7 * scene.length_s)


@recipe("2b")
def quiet_middle_low(rng, pick):
    scene = scene_of(rng, pick, 5000, 5.0, 50e-6, 57)
    return off_in_the_middle(scene, pick, 0.22 * scene.length_s, 0.78 * scene.length_s)


def voltage_early(rng, pick, early):
    scene = scene_of(rng, pick, 5000, 4.0, 50e-6, 175)
    on = (0.25 * scene.length_s, 0.75 * scene.length_s)
    early = pick(early, 0.1, 0.6)
    return scene.gated(on).voltage((on[0] - early, on[1] - early)).record()


@recipe("2c")
def voltage_early_03(rng, pick):
    return voltage_early(rng, pick, 0.3)


@recipe("2c-half")
def voltage_early_05(rng, pick):
    return voltage_early(rng, pick, 0.5)


@recipe("2d")
def second_burst(rng, pick):
    scene = scene_of(rng, pick, 5000, 4.0, 50e-6, 175)
    weak, length = pick(0.2, 0.1, 0.3), scene.length_s
    strong = gate(scene.amplitude_m, (0.2 * length, 0.55 * length))
    second = gate(weak * scene.amplitude_m, (0.7 * length, 0.85 * length))
    return scene.tone(lambda t: strong(t) + second(t)).with_fields(
        oracle_s=(0.2 * length, 0.55 * length)).record()


def slipped(rng, pick, left):
    scene = scene_of(rng, pick, 10000, 3.0, 150e-6, 225)
    at = 0.7 * scene.length_s  # 2.1 s of 3 s
    return scene.tone(lambda t: scene.amplitude_m * np.where(t < at, 1.0, left), phase=0.0
                      ).with_fields(oracle_s=(0.0, at)).record()


@recipe("2e")
def finger_slips(rng, pick):
    return slipped(rng, pick, pick(0.3, 0.1, 0.6))


@recipe("2f")
def tail_of_a_decay(rng, pick):
    scene = scene_of(rng, pick, 10000, 10.0, 20e-6, 439, noise=20e-9)
    tau = pick(6.0)
    return scene.tone(lambda t: scene.amplitude_m * np.exp(-t / tau), phase=0.0).record()


@recipe("3a")
def halves(rng, pick):
    return slipped(rng, pick, pick(0.5, 0.4, 0.8))


@recipe("3b")
def linear_decay(rng, pick):
    scene = scene_of(rng, pick, 10000, 3.0, 150e-6, 225)
    loss = pick(0.1, 0.05, 0.3)
    return scene.tone(lambda t: scene.amplitude_m * (1 - loss * t / scene.length_s)).record()


@recipe("4")
def never_on(rng, pick):
    return Scene(rng, 10000, pick(3.0), noise_m=pick(0.1547e-6)).record()


@recipe("5")
def clipped_few(rng, pick):
    scene = scene_of(rng, pick, 2000, 3.0, 50e-6, 331, noise=0.0)
    limit = scene.amplitude_m * pick(0.6, 0.5, 0.95)
    return scene.tone(phase=0.0).spoil(lambda x: np.minimum(x, limit)).record(0.0)


@recipe("6")
def codes(rng, pick):
    scene = scene_of(rng, pick, 5000, 3.0, 20e-6, 175)
    at = rng.integers(10, scene.t.size - 10, 5)

    def coded(x):
        x = x.copy()
        x[at] = -99.998e-3
        return x
    return scene.tone(phase=0.0).spoil(coded).with_fields(
        csv=True, column=("displacement_mm", 1e-3)).record()


def quantised(rng, pick, steps):
    scene = scene_of(rng, pick, 10000, 3.0, steps * 1e-6, 173.3, noise=0.0)
    return scene.tone(phase=0.0).spoil(lambda x: 1e-6 * np.round(x / 1e-6 + 0.5)).record(0.0)


@recipe("7a")
def three_steps(rng, pick):
    return quantised(rng, pick, 3.0)


@recipe("7b")
def less_than_a_step(rng, pick):
    return quantised(rng, pick, 0.8)


def swept_resonance(pick, length):
    """A resonance under a force of rising frequency, exact at the samples of a held force."""
    rate, f0, q = 10000.0, pick(150.0, 110, 220), pick(50.0, 20, 60)
    t = np.arange(int(length * rate)) / rate
    force = chirp(t, 60, length, 350, phi=-90)
    w0, damping = 2 * np.pi * f0 / rate, 1 / (2 * q)
    # bilinear in time, prewarped at f0; its width there shrinks by sin(w0)/w0
    k = w0 / np.tan(w0 / 2)
    b = np.array([1.0, 2.0, 1.0]) * w0 ** 2
    a = np.array([k * k + 2 * damping * w0 * k + w0 ** 2, 2 * (w0 ** 2 - k * k),
                  k * k - 2 * damping * w0 * k + w0 ** 2])
    x = 2e-6 * lfilter(b / a[0], a / a[0], force)
    return Record(rate, t, x, options=["--sweep"], truth={"f0": f0, "q": q * w0 / np.sin(w0)})


@recipe("8a")
def sweep_ten_seconds(rng, pick):
    return swept_resonance(pick, 10.0)


@recipe("8b")
def sweep_sixty_seconds(rng, pick):
    return swept_resonance(pick, 60.0)


@recipe("9")
def known_frequency_wrong(rng, pick):
    # below the 1280 readings/s that the band needs
    scene = Scene(rng, round(pick(1000, 800, 1250)), pick(10.0), pick(150.0), pick(20e-6), 0.0)
    told = scene.frequency_hz + pick(0.1, 0.05, 0.3)
    record = scene.tone().with_fields(options=["--drive-frequency", f"{told:.6f}Hz"]).record()
    record.truth = {"amplitude_m": scene.amplitude_m}
    return record


@recipe("10-spike")
def one_spike(rng, pick):
    scene = scene_of(rng, pick, 5000, 3.0, 20e-6, 175)
    at, height = rng.integers(scene.t.size // 4, 3 * scene.t.size // 4), pick(10e-3)
    return scene.tone().spoil(
        lambda x: x + np.where(np.arange(x.size) == at, height, 0)).record()


def at_the_corner(rng, pick, frequency):
    scene = Scene(rng, round(pick(5000)), pick(4.0), pick(frequency, 0.98 * frequency,
                                                         1.02 * frequency), 20e-6, 0.0)
    record = scene.tone().record()
    record.truth = {"corner": True}
    return record


@recipe("10-460hz")
def upper_corner(rng, pick):
    return at_the_corner(rng, pick, 460.0)


@recipe("10-22hz")
def lower_corner(rng, pick):
    return at_the_corner(rng, pick, 22.0)


@recipe("11-beat")
def beat(rng, pick):
    scene = scene_of(rng, pick, 5000, 5.0, 50e-6, 200)
    add_beat(scene, (-1.0, 100.0), pick(1.0, 0.3, 8))
    return scene.with_fields(oracle_s=(0.0, scene.length_s)).record()


@recipe("11-hum")
def strong_hum(rng, pick):
    scene = scene_of(rng, pick, 5000, 4.0, 20e-6, 175)
    return scene.tone().sine(pick(2.0, 1, 3) * scene.amplitude_m, 50.0).record()


# Refused without reason


@recipe("bump")
def bump(rng, pick):
    scene = scene_of(rng, pick, 4000, 5.0, 20e-6, 150)
    scene.tone(phase=0.0).bump(scene.length_s / 2, pick(20e-6), pick(0.05), pick(30.0))
    return scene.record()


@recipe("gated-beat")
def gated_beat(rng, pick):
    scene = scene_of(rng, pick, 5000, 4.0, 50e-6, 200)
    on = (0.2 * scene.length_s, 0.8 * scene.length_s)
    return add_beat(scene, on, pick(6.0, 4, 10)).record()


def beside_hum(rng, pick, length, on_s, hum):
    scene = scene_of(rng, pick, 5000, length, 20e-6, 175)
    begin = 0.5 * (scene.length_s - min(on_s, 0.7 * scene.length_s))
    scene.gated((begin, scene.length_s - begin))
    return scene.sine(hum * scene.amplitude_m, 50.0).record()


@recipe("long-beside-hum")
def long_beside_hum(rng, pick):
    return beside_hum(rng, pick, 4.4, 2.7, 0.5)


@recipe("equal-hum")
def equal_hum(rng, pick):
    return beside_hum(rng, pick, 4.0, 2.0, 1.0)


@recipe("row-missing")
def row_missing(rng, pick):
    scene = scene_of(rng, pick, 5000, 5.0, 20e-6, 175)
    missing = np.zeros(scene.t.size, bool)
    each = int(pick(0.3, 0.2, 0.6) * scene.rate_hz)
    missing[each::each] = True
    return without_rows(scene.tone().record(), missing)


def single_nans(rng, pick, rate, share):
    scene = Scene(rng, round(pick(rate, 0.8 * rate, rate)), pick(3.0), pick(175.0),
                  20e-6, 0.0)
    missing = rng.random(scene.t.size) < share
    return scene.tone().spoil(lambda x: np.where(missing, np.nan, x)).record()


@recipe("nan-2-percent")
def nan_two_percent(rng, pick):
    return single_nans(rng, pick, 20000, 0.02)


@recipe("nan-5-percent")
def nan_five_percent(rng, pick):
    return single_nans(rng, pick, 5000, 0.05)


@recipe("dropout")
def dropout(rng, pick):
    scene = scene_of(rng, pick, 5000, 3.0, 20e-6, 175, noise=log_uniform(rng, 1e-9, 1e-7))
    start, count = int(0.4 * scene.t.size), int(pick(0.01) * scene.rate_hz)
    on = (0.15 * scene.length_s, 0.9 * scene.length_s)
    return scene.gated(on).spoil(lambda x: blank(x, [start], [count])).record()
