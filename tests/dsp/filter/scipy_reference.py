"""Writes tests/dsp/filter/scipy_reference.h, or checks with --check that it still holds.

SciPy's own design (poles and zeros) and its own second-order sections: an implementation of the
band-pass that shares nothing with dsp/. The signal is an integer congruential noise on 1 mm of
offset, so that both sides have it to the last bit.
"""

import math
import pathlib
import re
import sys

try:
    import numpy as np
    from scipy import signal
except ImportError:
    print("needs python3-scipy")
    sys.exit(77)

RATE_HZ = 10000.0
SAMPLES = 4000
TARGET = pathlib.Path(__file__).with_name("scipy_reference.h")


def noise(count):
    """x' = (1103515245 x + 12345) mod 2^31, as (x / 2^31 - 0.5) um about 1 mm."""
    values, x = [], 1
    for _ in range(count):
        x = (1103515245 * x + 12345) % 2**31
        values.append(1e-3 + 1e-6 * (x / 2**31 - 0.5))
    return np.array(values)


def responses():
    rows = []
    for order in range(1, 9):
        zpk = signal.butter(order, [20, 500], "bandpass", fs=RATE_HZ, output="zpk")
        for hz in (5.0, 15.0, 20.0, 37.5, 100.0, 225.0, 499.0, 600.0, 2500.0):
            _, h = signal.freqz_zpk(*zpk, worN=[hz], fs=RATE_HZ)
            rows.append((order, hz, h[0].real, h[0].imag))
    return rows


def slowest_pole_distance():
    _, poles, _ = signal.butter(6, [20, 500], "bandpass", fs=50000.0, output="zpk")
    return 1 - max(abs(poles))


def filtered():
    """Causal from a constant start, and forward-backward with 3000 samples of odd padding."""
    rows = []
    x = noise(SAMPLES)
    for order in (2, 3, 4, 5):
        sos = signal.butter(order, [20, 500], "bandpass", fs=RATE_HZ, output="sos")
        causal, _ = signal.sosfilt(sos, x - x[0], zi=np.zeros((sos.shape[0], 2)))
        both = signal.sosfiltfilt(sos, x - x[0], padtype="odd", padlen=3000)
        for index in (0, 1, 2, 500, 2000, 3999):
            rows.append((order, index, causal[index], both[index]))
    return rows


def text():
    lines = [
        "#pragma once",
        "",
        "// Written by scipy_reference.py; do not edit.",
        "",
        "#include <array>",
        "#include <cstddef>",
        "",
        "namespace haptometer::dsp {",
        "",
        "// One pass of the 20-500 Hz band-pass, -3 dB at the corners, by poles and zeros.",
        "struct ResponsePoint {",
        "  int order;",
        "  double frequency_hz;",
        "  double real;",
        "  double imaginary;",
        "};",
        "",
        f"inline constexpr double kScipyResponseRateHz = {RATE_HZ!r};",
        "",
    ]
    rows = responses()
    lines.append(f"inline constexpr std::array<ResponsePoint, {len(rows)}> kScipyResponses{{{{")
    lines += [f"    {{{n}, {hz!r}, {float(re_)!r}, {float(im)!r}}}," for n, hz, re_, im in rows]
    lines += [
        "}};",
        "",
        "// 1 - |z| of the slowest pole, order 6, 50 kHz.",
        f"inline constexpr double kScipySlowestPoleDistance = {float(slowest_pole_distance())!r};",
        "",
        "// Samples of the filtered congruential noise (see the script), 10 kHz.",
        "struct FilteredSample {",
        "  int order;",
        "  std::size_t index;",
        "  double causal_m;",
        "  double zero_phase_m;",
        "};",
        "",
        f"inline constexpr std::size_t kScipySamples = {SAMPLES};",
        "",
    ]
    rows = filtered()
    lines.append(f"inline constexpr std::array<FilteredSample, {len(rows)}> kScipyFiltered{{{{")
    lines += [f"    {{{n}, {i}, {float(a)!r}, {float(b)!r}}}," for n, i, a, b in rows]
    lines += ["}};", "", "}  // namespace haptometer::dsp", ""]
    return "\n".join(lines)


NUMBER = re.compile(r"-?\d+\.?\d*(?:e[-+]?\d+)?")


def same(old, new):
    """Equal text around the numbers, and numbers equal to SciPy's own rounding, which differs between processors."""
    if NUMBER.split(old) != NUMBER.split(new):
        return False
    pairs = zip(NUMBER.findall(old), NUMBER.findall(new))
    return all(math.isclose(float(a), float(b), rel_tol=1e-9, abs_tol=1e-15) for a, b in pairs)


def main():
    if "--check" not in sys.argv:
        TARGET.write_text(text())
        return 0
    if same(TARGET.read_text(), text()):
        return 0
    print(f"{TARGET} is not what this script writes; run it without --check")
    return 1


sys.exit(main())
