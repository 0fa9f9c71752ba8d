"""Writes tests/dsp/spectrum/scipy_welch.h, or checks with --check that it still holds.

SciPy's Welch spectra, cross-spectra and coherence of two integer congruential noises (both sides
have them to the last bit), windows included: an implementation that shares nothing with dsp/.
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

RATE_HZ = 1000.0
SAMPLES = 500
SEGMENT = 64
TARGET = pathlib.Path(__file__).with_name("scipy_welch.h")
HFT90D = [1, 1.942604, 1.340318, 0.440811, 0.043097]
# name, window, overlap in samples, detrend
CASES = [
    ("kRectangularMean", "boxcar", 0, "constant"),
    ("kHannMean", "hann", 32, "constant"),
    ("kHammingNothing", "hamming", 16, False),
    ("kBlackmanHarrisMean", "blackmanharris", 48, "constant"),
    ("kFlatTopMean", "hft90d", 48, "constant"),
]


def noise(count, x):
    """x' = (1103515245 x + 12345) mod 2^31, as x / 2^31 - 0.5."""
    values = []
    for _ in range(count):
        x = (1103515245 * x + 12345) % 2**31
        values.append(x / 2**31 - 0.5)
    return np.array(values)


def window_of(name):
    if name == "hft90d":
        return signal.windows.general_cosine(SEGMENT, HFT90D, sym=False)
    return signal.get_window(name, SEGMENT)


def tables():
    x = noise(SAMPLES, 1)
    y = 3 * np.roll(x, 2) + noise(SAMPLES, 7)
    common = {"fs": RATE_HZ, "nperseg": SEGMENT}
    for name, window, overlap, detrend in CASES:
        options = {**common, "window": window_of(window), "noverlap": overlap, "detrend": detrend}
        yield name, signal.welch(x, **options)[1]
    options = {**common, "window": "hann", "noverlap": 32, "detrend": "constant"}
    cross = signal.csd(x, y, **options)[1]
    yield "kCrossReal", cross.real
    yield "kCrossImaginary", cross.imag
    yield "kCoherence", signal.coherence(x, y, **options)[1]


def header():
    lines = [
        "// Written by scipy_welch.py; python3-scipy's own numbers.",
        "// clang-format off: a number a line",
        "#pragma once",
        "",
        "#include <array>",
        "",
        "namespace haptometer::dsp::scipy_welch {",
        "",
    ]
    for name, values in tables():
        lines.append(f"inline constexpr std::array<double, {len(values)}> {name} = {{")
        lines += [f"    {value:.17g}," for value in values]
        lines += ["};", ""]
    lines += ["}  // namespace haptometer::dsp::scipy_welch", ""]
    return "\n".join(lines)


def numbers(text):
    return [float(x) for x in re.findall(r"^    (\S+),$", text, re.MULTILINE)]


def check():
    stored, fresh = numbers(TARGET.read_text()), numbers(header())
    assert len(stored) == len(fresh)
    largest = max(abs(x) for x in fresh)
    for old, new in zip(stored, fresh):
        # other versions of SciPy and its FFT round otherwise
        assert math.isclose(old, new, rel_tol=1e-9, abs_tol=1e-12 * largest), (old, new)


if __name__ == "__main__":
    if "--check" in sys.argv:
        check()
    else:
        TARGET.write_text(header())
