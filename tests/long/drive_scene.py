"""The parts that records are composed of: drives, slow motion, noise, disturbances, artifacts.

A Scene draws its rate, length, frequency, amplitude and noise at random, takes what a class adds to
it, and ends as a Record. Nothing here knows the program.
"""
import math

import numpy as np

from drive_record import OFFSET_M, Component, Record


def log_uniform(rng, low, high):
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def pieces(*points):
    """Amplitude that is linear between points (time, amplitude)."""
    times, levels = np.array(points, dtype=float).T
    return lambda t: np.interp(t, times, levels)


def gate(level, *intervals):
    """Amplitude that is level in the intervals [from, to) and 0 elsewhere."""
    return lambda t: level * np.any([(t >= low) & (t < high) for low, high in intervals], axis=0)


def shaped_noise(rng, count, rate_hz, density):
    """Gaussian noise with the one-sided density (power per Hz) density(f); not periodic."""
    size = 1 << (2 * count - 1).bit_length()
    f = np.fft.rfftfreq(size, 1 / rate_hz)
    spectrum = np.fft.rfft(rng.standard_normal(size)) * np.sqrt(density(f) * rate_hz / 2)
    return np.fft.irfft(spectrum, size)[:count]


class Scene:
    def __init__(self, rng, rate_hz=None, length_s=None, frequency_hz=None, amplitude_m=None,
                 noise_m=None):
        def drawn(value, low, high):
            return log_uniform(rng, low, high) if value is None else value
        self.rng = rng
        self.rate_hz = float(rate_hz or round(log_uniform(rng, 2e3, 20e3), -1))
        self.length_s = drawn(length_s, 1.5, 10.0)
        self.frequency_hz = frequency_hz or rng.uniform(40, 450)
        self.amplitude_m = drawn(amplitude_m, 0.5e-6, 200e-6)
        # noise of the band at most a fifth of the drive's RMS: the picture shows the drive
        most = 0.2 * self.amplitude_m / math.sqrt(2)
        self.noise_m = min(drawn(noise_m, 0.5e-9, 1e-6), most) if noise_m is None else noise_m
        self.t = np.arange(int(self.length_s * self.rate_hz)) / self.rate_hz
        self.drive, self.other = [], np.zeros(self.t.size)
        self.noise = None
        self.after = []  # artifacts of the readings, applied last
        self.fields = {}

    # The drive

    def tone(self, amplitude=None, frequency=None, phase=None):
        level = self.amplitude_m if amplitude is None else amplitude
        at = self.frequency_hz if frequency is None else frequency
        turn = self.rng.uniform(0, 2 * np.pi) if phase is None else phase
        self.drive.append(Component(level, at, turn))
        return self

    def interval(self, least_on_s=0.5, least_off_s=0.2):
        """An interval of the drive, off before and after it."""
        low = self.rng.uniform(max(least_off_s, 0.1 * self.length_s), 0.3 * self.length_s)
        high = self.rng.uniform(0.7 * self.length_s, self.length_s - max(least_off_s,
                                                                       0.1 * self.length_s))
        return low, max(high, low + least_on_s)

    def gated(self, on=None, level=None):
        on = on or self.interval()
        self.fields["oracle_s"] = on
        return self.tone(gate(self.amplitude_m if level is None else level, on))

    def walk(self, excursion_hz, step_s=0.02):
        """Frequency that walks at random over excursion_hz in all, smooth over some 0.2 s."""
        knots = np.arange(-1.0, self.length_s + 1.0, step_s)
        steps = np.convolve(self.rng.standard_normal(knots.size + 20), np.hanning(21), "valid")
        path = np.cumsum(steps[:knots.size])
        inside = path[(knots >= 0) & (knots <= self.length_s)]
        path = (path - inside.mean()) * excursion_hz / (inside.max() - inside.min())
        return knots, self.frequency_hz + path

    # Other motion

    def tremor(self, rms_m=None, frequency_hz=None):
        """Narrow tremor and slower drift, without power above 20 Hz."""
        rms = rms_m or log_uniform(self.rng, 20e-6, 300e-6)
        centre = frequency_hz or self.rng.uniform(7, 11)
        wide = self.rng.uniform(0.3, 0.8)

        def bell(sd, middle):
            return lambda f: np.exp(-((f - middle) / sd) ** 2 / 2) / (sd * math.sqrt(2 * math.pi))
        self.other += rms * shaped_noise(self.rng, self.t.size, self.rate_hz, bell(wide, centre))
        self.other += self.rng.uniform(0.5, 2) * rms * math.sqrt(0.5) * shaped_noise(
            self.rng, self.t.size, self.rate_hz, bell(0.3, 0.0))
        return self

    def sine(self, amplitude_m, frequency_hz, phase=None):
        turn = self.rng.uniform(0, 2 * np.pi) if phase is None else phase
        self.other += amplitude_m * np.sin(2 * np.pi * frequency_hz * self.t + turn)
        return self

    def hum(self, amplitude_m, mains_hz=None):
        mains = (mains_hz or self.rng.choice([50.0, 60.0])) + self.rng.uniform(-0.03, 0.03)
        self.sine(amplitude_m, mains)
        for order in (2, 3, 5):
            self.sine(amplitude_m * self.rng.uniform(0, 0.4), order * mains)
        return self

    def away_from_hum(self):
        """Draws the frequency until it is 8 Hz or more from multiples of 50 and 60 Hz."""
        while min(abs(self.frequency_hz - k * m) for m in (50, 60) for k in range(1, 10)) < 8:
            self.frequency_hz = self.rng.uniform(40, 450)
        return self

    def bump(self, at_s=None, amplitude_m=None, decay_s=None, frequency_hz=None):
        rng = self.rng
        at = rng.uniform(0.1, 0.9) * self.length_s if at_s is None else at_s
        height = amplitude_m or log_uniform(rng, 0.3, 3) * self.amplitude_m
        since = np.maximum(self.t - at, 0.0)
        ring = np.sin(2 * np.pi * (frequency_hz or rng.uniform(8, 40)) * since)
        self.other += height * np.exp(-since / (decay_s or rng.uniform(0.02, 0.1))) * ring
        return self

    # Noise: its RMS within 20 to 500 Hz is noise_m

    def white(self):
        sd = self.noise_m * math.sqrt(self.rate_hz / 2 / 480.0)
        self.noise = sd * self.rng.standard_normal(self.t.size)
        return self

    def red(self):
        corner = log_uniform(self.rng, 5, 60)
        f = np.linspace(20, 500, 4801)
        power = np.mean(1 / (1 + (f / corner) ** 2)) * 480.0
        self.noise = self.noise_m * shaped_noise(
            self.rng, self.t.size, self.rate_hz, lambda f: 1 / (1 + (f / corner) ** 2) / power)
        return self

    # Artifacts of the readings

    def spoil(self, change):
        """change(x) is applied to the finished displacement in m."""
        self.after.append(change)
        return self

    def with_fields(self, **fields):
        self.fields.update(fields)
        return self

    def voltage(self, *intervals, noise_v=0.0):
        """A drive channel of 2 V at the drive's frequency in the intervals."""
        on = gate(2.0, *intervals)(self.t)
        turn = np.sin(2 * np.pi * self.frequency_hz * self.t)
        noise = noise_v * self.rng.standard_normal(self.t.size)
        self.fields["voltage_v"] = on * turn + noise
        return self

    def record(self, offset_m=OFFSET_M):
        """The finished record; white noise unless another was drawn."""
        if self.noise is None:
            self.white()
        x = offset_m + self.other + sum(c.displacement_m(self.t) for c in self.drive)
        n = self.fields.get("averages", 1)
        if n > 1:  # each reading is the mean of n samples, which the readings' times end
            early = self.t[:, None] - np.arange(n) / self.rate_hz
            moved = sum(c.displacement_m(early) for c in self.drive)
            x += np.mean(moved, axis=1) - moved[:, 0] if self.drive else 0.0
        x = x + self.noise
        for change in self.after:
            x = change(x)
        fields = {"oracle_s": (0.0, self.length_s), **self.fields}
        return Record(self.rate_hz, self.t, x, self.drive, self.noise_m, **fields)
