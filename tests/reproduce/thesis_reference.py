#!/usr/bin/python3
"""Reference values of the rows of `haptometer reproduce` that the linear model answers.

Written from the equations of motion (J. Lindsay, "A Mechanical Amplifier for Haptic Feedback",
University of Washington, 2013, equations 2.1-2.4, with the reaction +Km i on the case), not from the
program: matrices by hand, phasors by numpy.linalg.solve, motion from rest by eigenvectors, an
interpolated input step by step, receptors counted one by one.

  thesis_reference.py            print the header
  thesis_reference.py --check    compare with thesis_reference.h beside this file; 0 when equal to
                                 1e-9 (another LAPACK rounds otherwise)
"""
import pathlib
import re
import sys

try:
    import numpy as np
    import scipy.linalg
except ImportError as missing:
    print(f"skipped: {missing}; install python3-numpy and python3-scipy")
    sys.exit(77)

MV, MC, KV, BV, KM, R, L = 1.4e-3, 0.6e-3, 2800, 0.0322, 1, 27, 130e-6
TUNED = (0.25e-3, 4.35e-3, 8200, 0.01)         # Ma1, Ma2, Ka, Ba: Table 2.4
BUILT = (0.25e-3, 4.6e-3, 8200, 0.01)          # the base as built
G = 9.80665


def skin(area_mm2):
    part = (np.cbrt(area_mm2) - 1) / (np.cbrt(100) - 1)
    return 600 + 1400 * part, 0.75 + 1.63 * part


def system(ks, bs, adapter=None, reaction=True):
    """x' = A x + b v with x = [i, xv, vv, xa, va(, xs, vs)]."""
    n = 7 if adapter else 5
    a = np.zeros((n, n))
    a[0, [0, 2, 4]] = -R / L, KM / L, -KM / L
    a[1, 2] = a[3, 4] = 1
    a[2, :5] = -KM / MV, -KV / MV, -BV / MV, KV / MV, BV / MV
    mass = MC + (adapter[0] if adapter else 0)
    a[4, :5] = KM * reaction / mass, KV / mass, BV / mass, -KV / mass, -BV / mass
    if adapter:
        _, m2, ka, ba = adapter
        a[5, 6] = 1
        a[4, 3:] += -ka / mass, -ba / mass, ka / mass, ba / mass
        a[6, 3:] = ka / m2, ba / m2, -(ka + ks) / m2, -(ba + bs) / m2
    else:
        a[4, 3:5] += -ks / mass, -bs / mass
    b = np.zeros(n)
    b[0] = 1 / L
    return a, b


def phasors(a, b, hertz=225, volts=5):
    return np.linalg.solve(2j * np.pi * hertz * np.eye(len(a)) - a, b * volts)


def rms(ks, bs, adapter=None, hertz=225):
    return abs(phasors(*system(ks, bs, adapter), hertz)[-2]) / np.sqrt(2)


def reach(a, b, level):
    """When |skin| is first `level`, from rest."""
    x = phasors(a, b)
    values, vectors = np.linalg.eig(a)
    weights = np.linalg.solve(vectors, -x.imag.astype(complex))

    def motion(t):
        forced = (x[-2] * np.exp(2j * np.pi * 225 * t)).imag
        return forced + (vectors[-2] * weights * np.exp(values * t)).sum().real

    step = 1 / 22500
    k = 1
    while abs(motion(k * step)) < level:
        k += 1
    low, high = (k - 1) * step, k * step
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if abs(motion(middle)) < level else (low, middle)
    return high


def interpolated_run(a, b, step, duration):
    """RMS of the skin over a whole run from rest, the input in straight lines between samples."""
    n, finer = len(a), 8
    g = np.zeros((n + 2, n + 2))
    g[:n, :n], g[:n, n], g[n, n + 1] = a, b, 1
    over = scipy.linalg.expm(g * step / finer)
    x, squares, count = np.zeros(n), 0.0, 0
    for k in range(round(duration / step)):
        u = 5 * np.sin(2 * np.pi * 225 * step * np.array([k, k + 1]))
        z = np.concatenate([x, [u[0], (u[1] - u[0]) / step]])
        for _ in range(finer):
            z = over @ z
            squares, count = squares + z[n - 2]**2, count + 1
        x = z[:n]
    return np.sqrt(squares / count)


def driver(hertz):
    """Force over velocity that the adapter's skin side answers with, from the seven states: hold the
    terminals, push with 1 N."""
    a, _ = system(0, 0, TUNED)
    push = np.zeros(7)
    push[6] = 1 / TUNED[1]
    return 1 / np.linalg.solve(2j * np.pi * hertz * np.eye(7) - a, push)[6]


def skin_impedance(hertz):
    ks, bs = skin(1)
    return bs + ks / (2j * np.pi * hertz)


def bisect(function, low, high):
    sign = function(high) > 0
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (low, middle) if (function(middle) > 0) == sign else (middle, high)
    return high


def sensitivity(place):
    most = 0
    for percent in range(-50, 51):
        numbers = [*TUNED, *skin(1)]
        numbers[place] *= 1 + percent / 100
        change = rms(numbers[4], numbers[5], tuple(numbers[:4])) / rms(*skin(1), TUNED) - 1
        most = max(most, abs(change))
    return most


def reached(radius_mm, spacing_mm):
    places = (np.arange(7) - 3) * spacing_mm
    return sum(np.hypot(x, y) <= radius_mm + 5.7 + 1e-9 for x in places for y in places)


def largest_stimulus(spacing_mm):
    """At the radii where the count steps up, or at 1 mm: the RMS falls between."""
    places = (np.arange(7) - 3) * spacing_mm
    radii = {1.0} | {np.hypot(x, y) - 5.7 for x in places for y in places}
    radii = [r for r in radii if r >= 1 and np.pi * r * r <= 100]
    return max(reached(r, spacing_mm) * rms(*skin(np.pi * r * r), TUNED) for r in radii)


def rows():
    direct, cone, tuned = system(*skin(78.5)), system(*skin(1)), system(*skin(1), TUNED)
    d, c, t = phasors(*direct), phasors(*cone), phasors(*tuned)
    peak = lambda x: abs(x[-2])
    yield "rms-direct", peak(d) / np.sqrt(2)
    yield "rms-cone", peak(c) / np.sqrt(2)
    yield "rms-adapter", peak(t) / np.sqrt(2)
    yield "ratio-adapter-direct", peak(t) / peak(d)
    yield "current", abs(d[0]) / np.sqrt(2)
    yield "power", 2.5 * d[0].real
    yield "phase", abs(np.angle(d[0]))
    yield "current-reduction", 1 - abs(t[0]) / abs(d[0])
    yield "power-reduction", 1 - t[0].real / d[0].real
    full = {name: reach(*s, 0.9 * peak(x)) for name, s, x in (("d", direct, d), ("t", tuned, t))}
    early = {name: reach(*s, 25e-6) for name, s in (("d", direct), ("c", cone), ("t", tuned))}
    yield "rise-ratio", full["t"] / full["d"]
    yield "amplitude-ratio", peak(t) / peak(d)
    yield "start-ratio", early["t"] / early["d"]
    yield "latency-adapter", full["t"]
    yield "start-direct", early["d"]
    yield "start-cone", early["c"]
    yield "start-adapter", early["t"]
    excess = lambda hertz: abs(driver(hertz)) - abs(skin_impedance(hertz))
    yield "impedance-match", bisect(excess, 215, 223)
    yield "impedance-ratio", abs(driver(225)) / abs(skin_impedance(225))
    for place, name in enumerate(("Ma1", "Ma2", "Ka", "Ba", "Ks", "Bs")):
        yield f"sensitivity-{name}", sensitivity(place)
    yield "receptors", float(reached(7.5, 15 / 7))
    yield "all-receptors-cell", (np.hypot(3, 3) * 15 / 7 - 5.7) * 1e-3
    yield "all-receptors-edge", (np.hypot(3, 3) * 15 / 6 - 5.7) * 1e-3
    yield "stimulus-adapter", largest_stimulus(15 / 7)
    yield "stimulus-direct", 49 * peak(d) / np.sqrt(2)
    yield "stimulus-ratio", largest_stimulus(15 / 7) / (49 * peak(d) / np.sqrt(2))
    yield "weight", 7.5e-3 * G
    yield "sag", 7.5e-3 * G / 600
    yield "built-ia1", rms(*skin(64), BUILT) / rms(*skin(78.5))
    yield "built-ia2", rms(*skin(1), BUILT) / rms(*skin(1.1))
    yield "gain-at-175hz", rms(*skin(1), TUNED, 175) / rms(*skin(78.5), None, 175)
    yield "power-saving", 1 - 0.66**2
    yield "power-possible", 1 - 1 / 16
    yield "mover-travel-adapter", abs(t[1] - t[3])
    yield "mover-travel-direct", abs(d[1] - d[3])
    yield "contact-force", abs((600 + 2j * np.pi * 225 * 0.75) * t[5])
    for name, contact in (("direct", direct), ("cone", cone), ("adapter", tuned)):
        yield f"interpolated-{name}", interpolated_run(*contact, 0.34e-3, 0.7)
    yield "phase-without-reaction", abs(np.angle(phasors(*system(*skin(78.5), None, False))[0]))


HEADER = """// Written by thesis_reference.py; do not edit.
// clang-format off
#pragma once

#include <string_view>

namespace haptometer::tests {{

struct ReferenceNumber {{
  std::string_view key;
  double value;  // SI
}};

inline constexpr ReferenceNumber kThesisReference[] = {{
{lines}
}};

}}  // namespace haptometer::tests
"""


def main():
    found = dict(rows())
    if sys.argv[1:] != ["--check"]:
        print(HEADER.format(lines="\n".join(f'    {{"{key}", {float(value)!r}}},' for key, value in found.items())), end="")
        return 0
    text = (pathlib.Path(__file__).parent / "thesis_reference.h").read_text()
    written = {key: float(value) for key, value in re.findall(r'\{"([^"]+)", ([^}]+)\}', text)}
    wrong = [key for key in found.keys() | written.keys()
             if abs(found.get(key, 0) - written.get(key, 0)) > 1e-9 * abs(written.get(key, 1))]
    print("differ:" if wrong else "all equal", *wrong)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
