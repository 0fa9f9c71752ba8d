"""Trial records of which the vibration of the drive is known, and the files that hold them.

A record is a drive (components of a frequency and an amplitude over time), other motion, noise and
artifacts. Truth is the drive alone: truth_rms_m() is its RMS over any window, each component
multiplied by the response of the documented band-pass at its frequency. Only NumPy; the documents
docs/explanation/filter.md and docs/reference/formats.md are the only source.
"""
import dataclasses
import json
import math
import struct
import zlib

import numpy as np

OFFSET_M = 30e-3


def band_gain(frequency_hz, band, rate_hz):
    """Zero-phase response of the band-pass: one pass forwards, one backwards (filter.md)."""
    low, high = (math.tan(math.pi * band[key] / rate_hz) for key in ("lower_hz", "upper_hz"))
    width = high - low
    if band["corner"] == "whole":
        width /= (math.sqrt(2) - 1) ** (1 / (2 * band["order"]))
    tangent = np.tan(np.pi * np.asarray(frequency_hz, dtype=float) / rate_hz)
    ratio = (low * high - tangent ** 2) / (width * tangent)
    return 1 / (1 + np.abs(ratio) ** (2 * band["order"]))


def default_band(order=6):
    return {"lower_hz": 20.0, "upper_hz": 500.0, "order": order, "corner": "whole"}


class Component:
    """amplitude(t) sin(2 pi integral of the frequency), the frequency linear between its knots."""

    def __init__(self, amplitude, frequency, phase=0.0):
        self.amplitude = amplitude if callable(amplitude) else lambda t: np.full(t.shape, amplitude)
        times, self.frequencies = frequency if isinstance(frequency, tuple) else (
            [-1.0, 100.0], [frequency] * 2)
        self.times, self.frequencies = np.asarray(times), np.asarray(self.frequencies)
        steps = np.diff(self.times) * (self.frequencies[1:] + self.frequencies[:-1]) / 2
        self.cycles = np.concatenate([[0.0], np.cumsum(steps)])
        self.start = phase / (2 * np.pi) - np.interp(0.0, self.times, self.cycles)

    def frequency_hz(self, t):
        return np.interp(t, self.times, self.frequencies)

    def displacement_m(self, t, gain=None):
        at = np.clip(np.searchsorted(self.times, t, "right") - 1, 0, self.times.size - 2)
        slope = np.diff(self.frequencies)[at] / np.diff(self.times)[at]
        since = t - self.times[at]
        cycles = self.cycles[at] + (self.frequencies[at] + slope * since / 2) * since
        level = self.amplitude(t)
        if gain is not None:
            level = level * gain(self.frequency_hz(t))
        return level * np.sin(2 * np.pi * ((self.start + cycles) % 1.0))


def kept_parts(window_s, excluded_s):
    """The window without what is excluded, as a list of (from, to)."""
    parts, begin = [], window_s[0]
    for low, high in sorted(excluded_s or []):
        if low > begin:
            parts.append((begin, min(low, window_s[1])))
        begin = max(begin, high)
    if begin < window_s[1]:
        parts.append((begin, window_s[1]))
    return parts


@dataclasses.dataclass
class Record:
    rate_hz: float
    times_s: np.ndarray
    displacement_m: np.ndarray  # NaN: no measurement
    drive: list = dataclasses.field(default_factory=list)
    noise_rms_m: float = 0.0  # in the default band
    voltage_v: np.ndarray | None = None
    csv: bool = False
    column: tuple = ("displacement_m", 1.0)  # its name, and of how many metres its unit is
    averages: int = 1
    drive_frequency_hz: float | None = None
    options: list = dataclasses.field(default_factory=list)
    floor: "Record | None" = None
    must_answer: bool = True  # an analyst who sees the picture would answer
    oracle_s: tuple | None = None  # where the drive is steady
    truth: dict = dataclasses.field(default_factory=dict)  # of other questions than the band's RMS

    def truth_rms_m(self, window_s, excluded_s=(), band=None):
        """RMS of the drive over the window, after the filter (band) or before it (None)."""
        gain = band and (lambda f: band_gain(f, band, self.rate_hz))
        squares = seconds = 0.0
        for low, high in kept_parts(window_s, excluded_s):
            # the midpoints of steps that divide the part: exact for whole periods
            count = max(8, math.ceil((high - low) * max(self.rate_hz, 5000.0)))
            t = low + (np.arange(count) + 0.5) * (high - low) / count
            total = sum((c.displacement_m(t, gain) for c in self.drive), np.zeros(count))
            squares += np.mean(total ** 2) * (high - low)
            seconds += high - low
        return math.sqrt(squares / seconds) if seconds > 0 else math.nan


# Files


def write_record(record, path):
    """Writes a trial.bin, or a CSV where rows or codes are what the record is about."""
    (write_csv if record.csv else write_bin)(record, path)


def write_csv(record, path):
    name, unit_m = record.column
    header = {"sampling_s": f"{1 / record.rate_hz:.12g}", "averages": record.averages,
              "source": "device"}
    if record.drive_frequency_hz:
        header["drive_frequency_hz"] = record.drive_frequency_hz
    names = ["time_s", name] + (["voltage_v"] if record.voltage_v is not None else [])
    columns = [np.char.mod("%.9f", record.times_s),
               np.char.mod("%.12g", record.displacement_m / unit_m)]
    if record.voltage_v is not None:
        columns.append(np.char.mod("%.6g", record.voltage_v))
    with open(path, "w", encoding="ascii") as file:
        file.writelines(f"# {key} = {value}\n" for key, value in header.items())
        file.write(",".join(names) + "\n")
        file.writelines(",".join(row) + "\n" for row in zip(*columns))


def trial_header(record, roles):
    texts = ("sensor", "head", "hold", "laser_spot", "utc_start", "host", "command_line")
    numbers = ("nominal_rate_hz", "drive_amplitude_v", "tare_m")
    channels = [{"name": role, "role": role, "unit": unit, "encoding": "f64", "scale": 1.0,
                 "offset": 0.0, "range_min": None, "range_max": None, "resolution": 0.0}
                for role, unit in roles]
    return {"format": "haptometer trial", "timing": "uniform", "rate_hz": record.rate_hz,
            "channels": channels, "source": "device", **dict.fromkeys(texts, ""),
            **dict.fromkeys(numbers), "sampling_s": 1 / record.rate_hz,
            "averages": record.averages, "drive_frequency_hz": record.drive_frequency_hz,
            "labels": {}, "fields": {}, "notes": []}


def block(kind, sequence, payload, rows=0, first=0):
    head = struct.pack("<8s4IQqI", b"\x93block\r\n", kind, sequence, rows, len(payload), first,
                       first, zlib.crc32(payload))
    return head + struct.pack("<I", zlib.crc32(head)) + payload


def write_bin(record, path):
    values = [(("displacement", "m"), record.displacement_m)]
    if record.voltage_v is not None:
        values.append((("voltage", "V"), record.voltage_v))
    header = json.dumps(trial_header(record, [role for role, _ in values])).encode()
    form = [(f"value{i}", "<f8") for i in range(len(values))]
    form += [(f"status{i}", "u1") for i in range(len(values))]
    rows = np.zeros(record.times_s.size, np.dtype(form))
    for i, (_, value) in enumerate(values):
        rows[f"value{i}"] = np.nan_to_num(value)
        rows[f"status{i}"] = np.where(np.isnan(value), 4, 0)  # 4: invalid
    with open(path, "wb") as file:
        file.write(b"\x93haptrial\r\n\x1a\n\x01\xfe\x00")
        file.write(block(1, 0, header) + block(1, 1, header))
        sequence = 2
        for first in range(0, rows.size, 8192):
            part = rows[first:first + 8192]
            file.write(block(2, sequence, part.tobytes(), part.size, first))
            sequence += 1
        invalid = int(np.count_nonzero(rows["status0"]))
        close = {"rows": rows.size, "statuses": {"ok": rows.size - invalid, "invalid": invalid}}
        file.write(block(4, sequence, json.dumps(close).encode(), first=rows.size))
