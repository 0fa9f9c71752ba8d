"""The classes of records: each a function from a random generator to a Record.

`hard` classes may be refused: an analyst who sees the picture would not answer all of them either.
The five parts: continuous and gated drives, drives that change, disturbances, artifacts of the
readings, drive channels; and records without a drive.
"""
import numpy as np

from drive_scene import Scene, gate, log_uniform, pieces

CLASSES = {}


def drive_class(name, hard=False):
    def add(make):
        def record(rng, seed):
            made = make(rng)
            made.must_answer = not hard
            return made
        CLASSES[name] = record
        return make
    return add


def off_class(name):
    def add(make):
        CLASSES[name] = lambda rng, seed: make(rng)
        return make
    return add


# Continuous and gated drives


@drive_class("continuous-clean")
def continuous_clean(rng):
    return Scene(rng, noise_m=0.0).tone().record()


@drive_class("continuous")
def continuous(rng):
    return Scene(rng).tone().record()


@drive_class("continuous-red")
def continuous_red(rng):
    return Scene(rng).tone().red().record()


@drive_class("gated")
def gated(rng):
    return Scene(rng).gated().record()


@drive_class("gated-red")
def gated_red(rng):
    return Scene(rng).gated().red().record()


def burst_times(scene, least_s, most_s):
    """Intervals of drive with pauses of 0.15 to 0.5 s, from 0.3 s on."""
    intervals, now = [], 0.3
    while now + most_s + 0.3 < scene.length_s:
        intervals.append((now, now + scene.rng.uniform(least_s, most_s)))
        now = intervals[-1][1] + scene.rng.uniform(0.15, 0.5)
    return intervals


@drive_class("bursts")
def bursts(rng):
    scene = Scene(rng, length_s=rng.uniform(3, 10))
    on = burst_times(scene, 0.4, 0.9)
    longest = max(on, key=lambda part: part[1] - part[0])
    return scene.tone(gate(scene.amplitude_m, *on)).with_fields(oracle_s=longest).record()


@drive_class("bursts-short", hard=True)
def bursts_short(rng):
    scene = Scene(rng, length_s=rng.uniform(2, 5))
    on = burst_times(scene, 0.05, 0.15)
    return scene.tone(gate(scene.amplitude_m, *on)).with_fields(oracle_s=None).record()


@drive_class("two-tones")
def two_tones(rng):
    scene = Scene(rng).tone()
    other = scene.frequency_hz + rng.choice([-1, 1]) * rng.uniform(30, 150)
    other = other if 30 < other < 450 else abs(scene.frequency_hz - 120) + 35
    return scene.tone(scene.amplitude_m * rng.uniform(0.2, 1), other).record()


@drive_class("two-tones-gated")
def two_tones_gated(rng):
    scene = Scene(rng)
    on = scene.interval()
    other = scene.frequency_hz * (0.6 if scene.frequency_hz > 200 else 1.7)
    scene.gated(on)
    second = gate(scene.amplitude_m * rng.uniform(0.2, 1), on)
    return scene.tone(second, other).record()


def add_square(scene, on):
    """The components of a square wave that a sensor without aliasing sees."""
    phase = scene.rng.uniform(0, 2 * np.pi)
    for order in range(1, int(0.45 * scene.rate_hz / scene.frequency_hz) + 1, 2):
        level = scene.amplitude_m / order
        scene.tone(gate(level, on), order * scene.frequency_hz, order * phase)
    return scene.with_fields(oracle_s=on)


@drive_class("square")
def square(rng):
    scene = Scene(rng, frequency_hz=rng.uniform(40, 200))
    return add_square(scene, (-1.0, scene.length_s + 1)).with_fields(
        oracle_s=(0.0, scene.length_s)).record()


@drive_class("square-gated")
def square_gated(rng):
    scene = Scene(rng, frequency_hz=rng.uniform(40, 200))
    return add_square(scene, scene.interval()).record()


@drive_class("on-before-start")
def on_before_start(rng):
    scene = Scene(rng)
    return scene.gated((-1.0, rng.uniform(0.4, 0.8) * scene.length_s)).record()


@drive_class("on-after-end")
def on_after_end(rng):
    scene = Scene(rng)
    return scene.gated((rng.uniform(0.2, 0.6) * scene.length_s, scene.length_s + 1)).record()


@drive_class("weak", hard=True)
def weak(rng):
    scene = Scene(rng, length_s=rng.uniform(2, 10), noise_m=log_uniform(rng, 50e-9, 1e-6))
    level = rng.uniform(0.3, 1.5) * np.sqrt(2) * scene.noise_m
    return scene.gated(level=level).record()


# Drives that change


@drive_class("ramps")
def ramps(rng):
    scene = Scene(rng, length_s=rng.uniform(2, 10))
    low, high = scene.interval()
    rise, fall = rng.uniform(0.05, 0.4, 2)
    level = pieces((low - rise, 0), (low, scene.amplitude_m), (high, scene.amplitude_m),
                   (high + fall, 0))
    return scene.tone(level).with_fields(oracle_s=(low, high)).record()


@drive_class("ramp-whole", hard=True)
def ramp_whole(rng):
    scene = Scene(rng)
    ends = rng.permutation([rng.uniform(0, 0.7), 1.0]) * scene.amplitude_m
    return scene.tone(pieces((0, ends[0]), (scene.length_s, ends[1]))).record()


@drive_class("modulated")
def modulated(rng):
    scene = Scene(rng, length_s=rng.uniform(2, 10))
    depth, rate, turn = rng.uniform(0.05, 0.6), rng.uniform(0.5, 5), rng.uniform(0, 6)
    return scene.tone(lambda t: scene.amplitude_m * (
        1 + depth * np.sin(2 * np.pi * rate * t + turn))).record()


@drive_class("frequency-modulated")
def frequency_modulated(rng):
    scene = Scene(rng, length_s=rng.uniform(2, 10))
    knots = np.arange(-1, scene.length_s + 1, 0.005)
    swing = rng.uniform(0.5, 5) * np.sin(2 * np.pi * rng.uniform(0.5, 4) * knots)
    return scene.tone(frequency=(knots, scene.frequency_hz + swing)).record()


def add_beat(scene, on, apart_hz):
    second = scene.amplitude_m * scene.rng.uniform(0.3, 1)
    scene.gated(on)
    return scene.tone(gate(second, on), scene.frequency_hz + apart_hz)


@drive_class("beat")
def beat(rng):
    scene = Scene(rng, length_s=rng.uniform(3, 10))
    add_beat(scene, (-1.0, scene.length_s + 1), log_uniform(rng, 0.3, 8))
    return scene.with_fields(oracle_s=(0.0, scene.length_s)).record()


@drive_class("beat-gated")
def beat_gated(rng):
    scene = Scene(rng, length_s=rng.uniform(3, 10))
    return add_beat(scene, scene.interval(), rng.uniform(2, 10)).record()


@drive_class("erm-spin-up")
def erm_spin_up(rng):
    scene = Scene(rng, length_s=rng.uniform(2.5, 10), frequency_hz=rng.uniform(80, 300))
    start, tau = rng.uniform(0.2, 0.5), rng.uniform(0.03, 0.12)
    knots, path = scene.walk(rng.uniform(0.3, 2), 0.005)
    speed = np.where(knots > start, 1 - np.exp(-np.maximum(knots - start, 0) / tau), 0)
    stop = scene.length_s * rng.uniform(0.8, 1.3)
    speed = np.where(knots > stop, np.exp(-(knots - stop).clip(0) / tau), speed)

    def level(t):  # the force of an unbalance grows with the square of the speed
        return scene.amplitude_m * np.interp(t, knots, speed) ** 2
    steady = (start + 6 * tau, min(stop, scene.length_s))
    return scene.tone(level, (knots, np.maximum(path * speed, 1e-3))).with_fields(
        oracle_s=steady).record()


@drive_class("drift-linear")
def drift_linear(rng):
    scene = Scene(rng, length_s=rng.uniform(2, 8))
    change = rng.choice([-1, 1]) * rng.uniform(1, 8)
    track = ([0.0, scene.length_s], [scene.frequency_hz, scene.frequency_hz + change])
    return scene.tone(frequency=track).record()


@drive_class("drift-walk")
def drift_walk(rng):
    scene = Scene(rng, length_s=rng.uniform(2, 8))
    return scene.tone(frequency=scene.walk(rng.uniform(1, 8))).record()


@drive_class("drift-gated")
def drift_gated(rng):
    scene = Scene(rng, length_s=rng.uniform(2, 8))
    on = scene.interval()
    return scene.tone(gate(scene.amplitude_m, on), scene.walk(rng.uniform(1, 8))).with_fields(
        oracle_s=on).record()


@drive_class("second-burst")
def second_burst(rng):
    scene = Scene(rng, length_s=rng.uniform(3, 10))
    first = (0.12 * scene.length_s, 0.55 * scene.length_s)
    second = (rng.uniform(0.65, 0.72) * scene.length_s, rng.uniform(0.8, 0.9) * scene.length_s)
    weaker = gate(scene.amplitude_m * rng.uniform(0.1, 0.3), second)
    strong = gate(scene.amplitude_m, first)
    return scene.tone(lambda t: strong(t) + weaker(t)).with_fields(oracle_s=first).record()


def step_level(scene, on, at, factor):
    after = scene.amplitude_m * factor
    return scene.tone(lambda t: np.where(t < at, gate(scene.amplitude_m, on)(t), gate(after, on)(t))
                      ).with_fields(oracle_s=max((on[0], at), (at, on[1]),
                                                 key=lambda p: p[1] - p[0]))


@drive_class("slip")
def slip(rng):
    scene = Scene(rng, length_s=rng.uniform(2, 10))
    at = rng.uniform(0.3, 0.8) * scene.length_s
    return step_level(scene, (0.0, scene.length_s), at, rng.uniform(0.2, 0.9)).record()


@drive_class("two-levels")
def two_levels(rng):
    scene = Scene(rng, length_s=rng.uniform(3, 10))
    on = scene.interval()
    at = rng.uniform(0.35, 0.65) * scene.length_s
    return step_level(scene, on, at, rng.choice([1, 2]) * rng.uniform(0.4, 0.8)).record()


@drive_class("slow-decay")
def slow_decay(rng):
    scene = Scene(rng, length_s=rng.uniform(3, 10))
    tau = scene.length_s * rng.uniform(0.5, 10)
    return scene.tone(lambda t: scene.amplitude_m * np.exp(-t / tau)).record()


# Disturbances


@drive_class("tremor")
def tremor(rng):
    return Scene(rng, length_s=rng.uniform(2, 10)).tone().tremor().record()


@drive_class("tremor-gated")
def tremor_gated(rng):
    return Scene(rng, length_s=rng.uniform(2, 10)).gated().tremor().record()


@drive_class("tremor-short", hard=True)
def tremor_short(rng):
    return Scene(rng, length_s=rng.uniform(0.5, 1.5)).tone().tremor().record()


@drive_class("tremor-harmonics")
def tremor_harmonics(rng):
    scene = Scene(rng, length_s=rng.uniform(2, 10), amplitude_m=log_uniform(rng, 10e-6, 200e-6))
    at, strong = rng.uniform(7, 11), rng.uniform(1, 5) * scene.amplitude_m
    scene.gated().tremor(strong, at)
    return scene.tremor(strong * rng.uniform(0.005, 0.05), 2 * at).record()


def hum_scene(rng):
    return Scene(rng, length_s=rng.uniform(2, 10)).away_from_hum()


@drive_class("hum-gated")
def hum_gated(rng):
    scene = hum_scene(rng).gated()
    scene.hum(scene.amplitude_m * log_uniform(rng, 0.05, 1.5))
    return scene.record()


@drive_class("hum-continuous", hard=True)
def hum_continuous(rng):
    scene = hum_scene(rng).tone()
    scene.hum(scene.amplitude_m * log_uniform(rng, 0.05, 1.5))
    return scene.record()


@drive_class("bumps")
def bumps(rng):
    scene = Scene(rng, length_s=rng.uniform(3, 10)).tone()
    for _ in range(rng.integers(1, 4)):
        scene.bump()
    return scene.record()


@drive_class("bumps-gated")
def bumps_gated(rng):
    scene = Scene(rng, length_s=rng.uniform(3, 10)).gated()
    for _ in range(rng.integers(1, 4)):
        scene.bump()
    return scene.record()


@drive_class("baseline-steps")
def baseline_steps(rng):
    scene = Scene(rng, length_s=rng.uniform(3, 10)).gated()
    for _ in range(rng.integers(1, 3)):  # the target is moved within some 50 ms
        at, move = rng.uniform(0.1, 0.9) * scene.length_s, log_uniform(rng, 10e-6, 1e-3)
        scene.other += move / (1 + np.exp(-(scene.t - at) / 0.02))
    return scene.record()


# Artifacts of the readings


def blank(x, starts, counts):
    x = x.copy()
    for start, count in zip(starts, counts):
        x[start:start + count] = np.nan
    return x


@drive_class("gaps-nan")
def gaps_nan(rng):
    scene = Scene(rng, length_s=rng.uniform(3, 10)).gated()
    number = rng.integers(1, 5)
    starts = rng.integers(0, scene.t.size, number)
    counts = (np.exp(rng.uniform(np.log(1), np.log(0.03 * scene.rate_hz), number))).astype(int) + 1
    return scene.spoil(lambda x: blank(x, starts, counts)).record()


@drive_class("nan-single")
def nan_single(rng):
    scene = Scene(rng, rate_hz=rng.uniform(5e3, 20e3)).gated()
    missing = rng.random(scene.t.size) < rng.uniform(0.002, 0.03)
    return scene.spoil(lambda x: np.where(missing, np.nan, x)).record()


def without_rows(record, missing):
    kept = ~missing
    record.times_s, record.displacement_m = record.times_s[kept], record.displacement_m[kept]
    if record.voltage_v is not None:
        record.voltage_v = record.voltage_v[kept]
    record.csv = True
    return record


@drive_class("rows-missing")
def rows_missing(rng):
    scene = Scene(rng, rate_hz=rng.uniform(3e3, 10e3), length_s=rng.uniform(2, 5)).gated()
    missing = np.zeros(scene.t.size, bool)
    for start in rng.integers(100, scene.t.size - 100, rng.integers(1, 15)):
        missing[start:start + rng.integers(1, 4)] = True
    return without_rows(scene.record(), missing)


@drive_class("held")
def held(rng):
    scene = Scene(rng, length_s=rng.uniform(2, 10)).gated()
    starts = rng.integers(1, scene.t.size - 100, rng.integers(1, 20))
    counts = rng.integers(2, max(4, int(0.008 * scene.rate_hz)), starts.size)

    def hold(x):
        x = x.copy()
        for start, count in zip(starts, counts):
            x[start:start + count] = x[start - 1]
        return x
    return scene.spoil(hold).record()


@drive_class("spikes")
def spikes(rng):
    scene = Scene(rng, length_s=rng.uniform(2, 10)).gated()
    at = rng.integers(5, scene.t.size - 5, rng.integers(1, 10))
    height = rng.choice([-1, 1], at.size) * np.exp(rng.uniform(np.log(3), np.log(1e3), at.size))

    def strike(x):
        x = x.copy()
        x[at] += height * scene.amplitude_m
        return x
    return scene.spoil(strike).record()


def clipped_at(scene, share):
    """The sensor's limit lies at the share of the amplitude; the truth is the unclipped drive."""
    limit = 30e-3 + share * scene.amplitude_m
    return scene.spoil(lambda x: np.minimum(x, limit))


@drive_class("clipped", hard=True)
def clipped(rng):
    scene = Scene(rng, length_s=rng.uniform(2, 10)).gated()
    return clipped_at(scene, rng.uniform(0.5, 0.97)).record()


@drive_class("clipped-few-a-period", hard=True)
def clipped_few(rng):
    scene = Scene(rng, rate_hz=rng.uniform(1500, 2500), frequency_hz=rng.uniform(200, 450))
    return clipped_at(scene.tone(), rng.uniform(0.5, 0.97)).record()


@drive_class("clipped-by-tremor", hard=True)
def clipped_tremor(rng):
    scene = Scene(rng, length_s=rng.uniform(3, 10), amplitude_m=log_uniform(rng, 10e-6, 200e-6))
    scene.gated().tremor(3 * scene.amplitude_m)
    return scene.spoil(lambda x: np.minimum(x, np.quantile(x, rng.uniform(0.95, 0.995)))).record()


def rounded(scene, step_m):
    offset = scene.rng.uniform(0, 1)
    return scene.spoil(lambda x: step_m * np.floor(x / step_m + offset))


@drive_class("quantised", hard=True)
def quantised(rng):
    scene = Scene(rng, noise_m=0.0, amplitude_m=log_uniform(rng, 2e-6, 20e-6)).gated()
    return rounded(scene, scene.amplitude_m / log_uniform(rng, 0.6, 30)).record()


@drive_class("quantised-dithered")
def quantised_dithered(rng):
    scene = Scene(rng, amplitude_m=log_uniform(rng, 2e-6, 20e-6)).gated()
    each = scene.noise_m * np.sqrt(scene.rate_hz / 960)  # of each reading
    return rounded(scene, each * rng.uniform(0.2, 1.8)).record()


@drive_class("jitter")
def jitter(rng):
    scene = Scene(rng, rate_hz=rng.uniform(4e3, 10e3), length_s=rng.uniform(2, 5))
    share = log_uniform(rng, 0.005, 0.2)
    scene.t = scene.t + share * rng.uniform(-1, 1, scene.t.size) / scene.rate_hz
    scene.t = np.maximum(scene.t - scene.t[0], 0.0)
    return scene.gated().with_fields(csv=True).record()


def averaged_scene(rng, **given):
    scene = Scene(rng, **given)
    n = int(rng.choice([2, 4, 8, 16]))
    most = min(450.0, 0.4 * scene.rate_hz / n)
    scene.frequency_hz = rng.uniform(min(40.0, 0.8 * most), most)
    return scene.with_fields(averages=n)


@drive_class("averaged")
def averaged(rng):
    return averaged_scene(rng).tone().record()


@drive_class("averaged-gated")
def averaged_gated(rng):
    return averaged_scene(rng).gated().record()


@drive_class("codes-in-mm")
def codes_in_mm(rng):
    scene = Scene(rng, rate_hz=rng.uniform(3e3, 10e3), length_s=rng.uniform(2, 5)).gated()
    code = rng.choice([-99.998, 99.998, -999.99, 99.9999]) * 1e-3
    starts = rng.integers(5, scene.t.size - 50, rng.integers(1, 10))
    counts = rng.integers(1, 20, starts.size)

    def coded(x):
        x = blank(x, starts, counts)
        return np.where(np.isnan(x), code, x)
    return scene.spoil(coded).with_fields(csv=True, column=("displacement_mm", 1e-3)).record()


# Floors and drive channels


def with_floor(record, scene):
    """A trial of the same sensor, the drive off, for --floor."""
    off = Scene(scene.rng, scene.rate_hz, scene.length_s, noise_m=scene.noise_m).white()
    record.floor = off.with_fields(averages=record.averages).record()
    return record


@drive_class("floor-file")
def floor_file(rng):
    scene = Scene(rng, length_s=rng.uniform(3, 10))
    scene.noise_m = scene.amplitude_m / np.sqrt(2) * rng.uniform(0.05, 0.8)
    return with_floor(scene.tone().record(), scene)


@drive_class("floor-file-averaged")
def floor_file_averaged(rng):
    scene = averaged_scene(rng, length_s=rng.uniform(3, 10))
    scene.noise_m = scene.amplitude_m / np.sqrt(2) * rng.uniform(0.05, 0.5)
    return with_floor(scene.tone().record(), scene)


def channel_scene(rng):
    scene = Scene(rng, length_s=rng.uniform(3, 10))
    on = scene.interval(least_off_s=0.6)
    return scene.gated(on), on


@drive_class("channel-right")
def channel_right(rng):
    scene, on = channel_scene(rng)
    ahead = rng.uniform(0, 0.005)
    return scene.voltage((on[0] - ahead, on[1] - ahead), noise_v=1e-3).record()


@drive_class("channel-late")
def channel_late(rng):
    scene, on = channel_scene(rng)
    late = rng.uniform(0.02, 0.5)
    return scene.voltage((on[0] + late, on[1] + late), noise_v=1e-3).record()


@drive_class("channel-early")
def channel_early(rng):
    scene, on = channel_scene(rng)
    early = rng.uniform(0.02, 0.5)
    return scene.voltage((on[0] - early, on[1] - early), noise_v=1e-3).record()


@drive_class("channel-dead")
def channel_dead(rng):
    scene, _ = channel_scene(rng)
    return scene.voltage(noise_v=rng.choice([0.0, 1e-3])).record()


@drive_class("channel-contradicts", hard=True)
def channel_contradicts(rng):
    scene, on = channel_scene(rng)
    return scene.voltage((-1.0, on[0]), (on[1], scene.length_s + 1), noise_v=1e-3).record()


@drive_class("channel-always-on", hard=True)
def channel_always_on(rng):
    scene, _ = channel_scene(rng)
    return scene.voltage((-1.0, scene.length_s + 1), noise_v=1e-3).record()


@drive_class("everything", hard=True)
def everything(rng):
    scene = Scene(rng, rate_hz=rng.uniform(4e3, 10e3), length_s=rng.uniform(3, 6),
                  amplitude_m=log_uniform(rng, 10e-6, 200e-6)).away_from_hum()
    on = scene.interval()
    scene.fields["oracle_s"] = on
    scene.tone(gate(scene.amplitude_m, on), scene.walk(rng.uniform(0.5, 4))).tremor().bump()
    scene.hum(scene.amplitude_m * rng.uniform(0.02, 0.3)).voltage(on, noise_v=1e-3)
    start, at = rng.integers(0, scene.t.size - 100, 2)
    scene.spoil(lambda x: x + np.where(np.arange(x.size) == at, 20 * scene.amplitude_m, 0))
    scene.spoil(lambda x: blank(x, [start], [rng.integers(1, 30)]))
    missing = np.zeros(scene.t.size, bool)
    missing[rng.integers(100, scene.t.size - 100, 4)] = True
    return without_rows(scene.record(), missing)


# Without a drive


def silent(rng, **given):
    return Scene(rng, **{"noise_m": log_uniform(rng, 0.5e-9, 1e-6), **given})


@off_class("off-white")
def off_white(rng):
    return silent(rng).record()


@off_class("off-red")
def off_red(rng):
    return silent(rng).red().record()


@off_class("off-tremor")
def off_tremor(rng):
    return silent(rng).tremor().record()


@off_class("off-bumps")
def off_bumps(rng):
    scene = silent(rng, length_s=rng.uniform(3, 10))
    for _ in range(rng.integers(1, 6)):
        scene.bump()
    return scene.record()


@off_class("off-hum")
def off_hum(rng):
    return silent(rng).hum(log_uniform(rng, 0.1e-6, 20e-6)).record()


@off_class("off-impulse")
def off_impulse(rng):
    scene = silent(rng)
    at, height = rng.integers(10, scene.t.size - 10), log_uniform(rng, 1e-6, 1e-3)
    scene.other[at:at + rng.integers(1, 4)] += height
    return scene.record()


@off_class("off-constant")
def off_constant(rng):
    return silent(rng, noise_m=0.0).record()


@off_class("off-noise-steps")
def off_noise_steps(rng):
    scene = silent(rng, length_s=rng.uniform(3, 10)).white()
    low, high = scene.interval()
    louder = (scene.t >= low) & (scene.t < high)
    scene.noise = np.where(louder, rng.uniform(1.5, 5), 1.0) * scene.noise
    return scene.record()


@off_class("off-channel-on")
def off_channel_on(rng):
    scene = silent(rng, length_s=rng.uniform(3, 10))
    return scene.voltage(scene.interval(), noise_v=1e-3).record()


@off_class("off-everything")
def off_everything(rng):
    scene = silent(rng, length_s=rng.uniform(3, 10)).tremor().hum(log_uniform(rng, 1e-7, 1e-5))
    return scene.bump().spoil(lambda x: blank(x, [x.size // 3], [5])).record()
