#!/usr/bin/python3
"""Reference values of tuning under a latency limit: latencies of adapters, and a dense search.

Written from the equations of motion (see limited_reference.py) and from what the headers say of the
latency (sim/skin/skin_rise.h, dsp/spectrum/envelope.h, dsp/spectrum/envelope.h, sim/effective_scene.h), not from
the program: the motion from rest as a sum over eigenvectors, the envelope by least squares in each
window, the crossings by straight lines.

  latency_reference.py            search and print the header; some minutes
  latency_reference.py --check    compute RMS and latency of the kept adapters anew; 0 when equal
"""
import pathlib
import re
import sys

try:
    import numpy as np
    from scipy.optimize import differential_evolution, minimize
except ImportError as missing:
    print(f"skipped: {missing}; install python3-scipy")
    sys.exit(77)

MV, MC, KV, BV, KM, R, L, VOLT = 1.4e-3, 0.6e-3, 2800, 0.0322, 1, 27, 130e-6, 5
LOW = np.array([0.25e-3, 0.25e-3, 2000, 0.01, 0.0])  # Ma1, Ma2, Ka, Ba, place of the area
HIGH = np.array([10e-3, 10e-3, 12000, 0.1, 1.0])
CASES = [(225, 2.6e-3), (225, 1.5e-3), (150, 2e-3), (400, 1e-3)]  # Hz, limit in s
SPOTS = 6  # further adapters, of any latency


def skin(place):
    return 600 + 1400 * place, 0.75 + 1.63 * place


def matrix(x):
    """x' = A x + b v of xv, vv, xa, va, xs, vs, i."""
    Ma1, Ma2, Ka, Ba, place = LOW + (HIGH - LOW) * x
    Ks, Bs = skin(place)
    m = MC + Ma1
    a = np.array([[0, 1, 0, 0, 0, 0, 0],
                  [-KV / MV, -BV / MV, KV / MV, BV / MV, 0, 0, -KM / MV],
                  [0, 0, 0, 1, 0, 0, 0],
                  [KV / m, BV / m, -(KV + Ka) / m, -(BV + Ba) / m, Ka / m, Ba / m, KM / m],
                  [0, 0, 0, 0, 0, 1, 0],
                  [0, 0, Ka / Ma2, Ba / Ma2, -(Ka + Ks) / Ma2, -(Ba + Bs) / Ma2, 0],
                  [0, KM / L, 0, -KM / L, 0, 0, -R / L]])
    return a, np.array([0, 0, 0, 0, 0, 0, 1 / L])


def motion(x, hertz):
    """RMS of the skin, and its positions over the run with their rate."""
    a, b = matrix(x)
    w = 2 * np.pi * hertz
    phasor = np.linalg.solve(1j * w * np.eye(7) - a, b * VOLT)  # of exp(j w t); v is its imaginary part
    poles, vectors = np.linalg.eig(a)
    parts = np.linalg.solve(vectors, -phasor.imag) * vectors[4]
    own_hz = max(abs(poles.imag) / 2 / np.pi)
    rate = 64 * hertz * max(1, np.ceil(16 * own_hz / (64 * hertz)))
    run_s = np.ceil(1e3 * max(0.5, 40 / hertz)) / 1e3
    t = np.arange(int(np.floor(run_s * rate * (1 + 1e-12))) + 1) / rate
    positions = (phasor[4] * np.exp(1j * w * t)).imag
    for pole, part in zip(poles, parts):
        positions = positions + (part * np.exp(pole * t)).real
    return abs(phasor[4]) / np.sqrt(2), positions, rate


def kernel(size, step):
    half = (size - 1) / 2
    t = np.arange(size) - half
    columns = np.stack([np.cos(step * t), np.sin(step * t), np.ones(size), t / half, (t / half)**2], 1)
    weights = 0.5 + 0.5 * np.cos(2 * np.pi * t / (size + 1))
    return np.linalg.solve(columns.T @ (weights[:, None] * columns), columns.T * weights)[:2]


def own_rise(rows, step):
    """Samples from 10 % to 90 % of a tone that begins in the window's middle."""
    size = rows.shape[1]
    phase = step * (np.arange(size) - (size - 1) / 2)
    sums = np.concatenate([[0], np.cumsum((rows[0] * np.cos(phase) + rows[1] * np.sin(phase)) / 2)])
    k = int(np.argmax((sums[:-1] < 0.1) & (sums[1:] >= 0.1)))
    for later in range(k, size):  # the last such crossing
        if sums[later] < 0.1 <= sums[later + 1]:
            k = later
    return size - 2 * (k + (0.1 - sums[k]) / (sums[k + 1] - sums[k]))


def latency(x, hertz):
    """Skin RMS and latency, NaN where the amplitude does not pass both levels."""
    rms, positions, rate = motion(x, hertz)
    quiet = int(np.ceil(6 / hertz * rate))
    signal = np.concatenate([np.zeros(quiet), positions])
    size = int(np.round(3 * rate / hertz))
    hop = max(1, size // 32)
    rows = kernel(size, 2 * np.pi * hertz / rate)
    windows = np.lib.stride_tricks.sliding_window_view(signal, size)[::hop]
    amplitude = np.linalg.norm((windows - windows[:, :1]) @ rows.T, axis=1)
    start = (size - 1) / 2 / rate
    times = start + np.arange(len(amplitude)) * hop / rate
    end = min(times[-1], quiet / rate + (len(positions) - 1) / rate - size / rate / 2)
    steady = amplitude[(times >= end - 10 / hertz - 1e-12) & (times <= end + 1e-12)]
    level = amplitude / np.sqrt(np.mean(steady**2))
    rises = lambda at: np.flatnonzero((level[:-1] < at) & (level[1:] >= at))
    cross = lambda k, at: k + (at - level[k]) / (level[k + 1] - level[k])
    halves = rises(0.5)
    if not len(halves):
        return rms, np.nan
    lows, highs = rises(0.1), rises(0.9)
    lows, highs = lows[lows <= halves[0]], highs[highs >= halves[0]]
    if not len(lows) or not len(highs):
        return rms, np.nan
    low, half, high = cross(lows[-1], 0.1), cross(halves[0], 0.5), cross(highs[0], 0.9)
    own = own_rise(rows, 2 * np.pi * hertz / rate) / rate
    measured = (high - low) * hop / rate
    drawn = np.sqrt(1 - (own / measured)**2) if measured > own else 0
    return rms, start + half * hop / rate - (half - low) * hop / rate * drawn - quiet / rate


def search(hertz, limit):
    """The largest RMS within the limit: differential evolution, then SLSQP from the best."""
    def penal(x):
        rms, late = latency(np.clip(x, 0, 1), hertz)
        if not np.isfinite(late):
            return 1e3
        return -np.log(rms) + 50 * max(0, late / limit - 1)

    first = differential_evolution(penal, [(0, 1)] * 5, popsize=12, maxiter=70, seed=5, polish=False,
                                   tol=0, init="sobol")
    best = first.x
    for width in (1e-2, 1e-3, 1e-4, 1e-4):
        found = minimize(lambda x: -np.log(latency(x, hertz)[0]), best, method="SLSQP",
                         bounds=[(0, 1)] * 5, options={"eps": width, "maxiter": 30, "ftol": 1e-12},
                         constraints={"type": "ineq",
                                      "fun": lambda x: 1 - latency(x, hertz)[1] / limit})
        x = np.clip(found.x, 0, 1)
        if penal(x) < penal(best):
            best = x
    rms, late = latency(best, hertz)
    if late > limit:  # to the limit's inside, along the line to an adapter that is there
        inside = next(x for x in np.linspace(best, np.where(best > 0.02, best - 0.02, best), 400)
                      if latency(x, hertz)[1] <= limit)
        best = inside
    return best


def row(x, hertz, limit):
    rms, late = latency(x, hertz)
    numbers = ", ".join(f"{float(number)!r}" for number in x)
    return f"    {{{hertz}, {limit!r}, {{{numbers}}}, {rms:.10e}, {late:.10e}}},"


def header():
    rng = np.random.default_rng(2)
    lines = ["// Written by latency_reference.py; do not edit.", "// clang-format off", "#pragma once",
             "", "#include <array>", "", "namespace haptometer::tests {", "",
             "/// An adapter's skin RMS and latency; with a limit the best of a dense search under it.",
             "struct LatencyCase {", "  double frequency_hz, limit_s;",
             "  std::array<double, 5> place;  ///< of Ma1, Ma2, Ka, Ba and the area within the bounds",
             "  double rms_m, latency_s;", "};",
             "inline constexpr LatencyCase kLatencyCases[] = {"]
    for hertz, limit in CASES:
        lines.append(row(search(hertz, limit), hertz, limit))
        print(lines[-1], file=sys.stderr)
    kept = 0
    while kept < SPOTS:
        x, hertz = rng.random(5), int(rng.integers(60, 400))
        if np.isfinite(latency(x, hertz)[1]):
            lines.append(row(x, hertz, 0))
            kept += 1
    return "\n".join([*lines, "};", "", "}  // namespace haptometer::tests", ""])


def check():
    text = pathlib.Path(__file__).with_suffix(".h").read_text()
    kept = re.findall(r"^    \{(.+?), (.+?), \{(.+?)\}, (.+?), (.+?)\},$", text, re.M)
    if len(kept) != len(CASES) + SPOTS:
        print(f"latency_reference.h has {len(kept)} adapters")
        return 1
    for hertz, _, numbers, rms, late in kept:
        ours = latency(np.array([float(number) for number in numbers.split(", ")]), float(hertz))
        if abs(ours[0] / float(rms) - 1) > 1e-9 or abs(ours[1] - float(late)) > 1e-9:
            print(f"at {hertz} Hz {numbers}: {ours}, not {rms}, {late}")
            return 1
    return 0


def main():
    if "--check" in sys.argv:
        return check()
    print(header(), end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())
