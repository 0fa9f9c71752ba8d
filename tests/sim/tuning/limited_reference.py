#!/usr/bin/python3
"""Reference values of tuning within a limited travel of the mover: SciPy's SLSQP from many starts.

Written from the equations of motion (J. Lindsay, "A Mechanical Amplifier for Haptic Feedback",
University of Washington, 2013, equations 2.1-2.4, with the reaction +Km i on the case), not from the
program. The four phasor equations are solved as eight real ones, whose derivatives are those of a
complex step (Squire and Trapp, SIAM Review 40 (1998) 110), so that they are exact. All five numbers
of the adapter are free; nothing is eliminated. Starts, eight for each stretch of areas: of the best
of random points, those beyond the limit ranked by how far. Two starts at least must agree.

  limited_reference.py            print the header
  limited_reference.py --check    compare three of the cases with limited_reference.h beside this
                                  file, --check-all every one; 0 when equal
"""
import pathlib
import re
import sys

try:
    import numpy as np
    from scipy.optimize import minimize
except ImportError as missing:
    print(f"skipped: {missing}; install python3-scipy")
    sys.exit(77)

MV, MC, KV, BV, KM, R, L = 1.4e-3, 0.6e-3, 2800, 0.0322, 1, 27, 130e-6
LOW = np.array([0.25e-3, 0.25e-3, 2000, 0.01, 0.0])  # Ma1, Ma2, Ka, Ba, place of the area
HIGH = np.array([10e-3, 10e-3, 12000, 0.1, 1.0])
PAD_MM, FIELD_MM = 15, 5.7
RELATIVE = 1e-8  # of --check: SLSQP's last steps differ between builds of LAPACK

# objective, limit in mm, then what differs from the thesis's 5 V at 225 Hz, its bounds and skin law
CASES = [("SkinRms", limit, {}) for limit in (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0)]
CASES += [("Stimulus", limit, {}) for limit in (0.1, 0.3, 0.5)]
CASES += [("SkinPower", limit, {}) for limit in (0.1, 0.3, 0.6)]
CASES += [("SkinRms", 0.3, {"volt": 3}), ("SkinRms", 0.9, {"volt": 9}),
          ("SkinRms", 0.5, {"hertz": 60}), ("SkinRms", 0.6, {"hertz": 140}),
          ("SkinRms", 0.1, {"hertz": 400}),
          ("SkinRms", 0.3, {"Ks": 1500, "Bs": 2}), ("SkinPower", 0.4, {"Ks": 1500, "Bs": 2}),
          ("SkinRms", 0.45, {"Ma2": 8e-3})]


def skin(place):
    """Ks and Bs; `place` of the way between the cube roots of 1 and 100 mm2."""
    return 600 + 1400 * place, 0.75 + 1.63 * place


def motion(x, case):
    """|xs|^2, |xv - xa|^2 and Bs of adapters x (..., 5); analytic in x."""
    Ma1, Ma2, Ka, Ba, place = np.moveaxis(LOW + (HIGH - LOW) * x, -1, 0)
    Ks, Bs = skin(place)
    if "Ks" in case:
        Ks, Bs = case["Ks"] + 0 * place, case["Bs"] + 0 * place
    w = 2 * np.pi * case.get("hertz", 225)
    real = np.zeros((*Ma1.shape, 4, 4), Ma1.dtype)
    imag = np.zeros_like(real)
    rows = [[(R, L * w), (0, -KM * w), (0, KM * w), (0, 0)],
            [(KM, 0), (KV - MV * w**2, BV * w), (-KV, -BV * w), (0, 0)],
            [(-KM, 0), (-KV, -BV * w), (KV + Ka - (MC + Ma1) * w**2, (BV + Ba) * w), (-Ka, -Ba * w)],
            [(0, 0), (0, 0), (-Ka, -Ba * w), (Ka + Ks - Ma2 * w**2, (Ba + Bs) * w)]]
    for i, row in enumerate(rows):
        for j, (re, im) in enumerate(row):
            real[..., i, j], imag[..., i, j] = re, im
    matrix = np.block([[real, -imag], [imag, real]])
    right = np.zeros((*Ma1.shape, 8, 1), Ma1.dtype)
    right[..., 0, 0] = case.get("volt", 5)
    z = np.linalg.solve(matrix, right)[..., 0]
    xv, xa, xs = ((z[..., k], z[..., k + 4]) for k in (1, 2, 3))
    return (xs[0]**2 + xs[1]**2, (xv[0] - xa[0])**2 + (xv[1] - xa[1])**2, Bs)


def receptors(radius_mm):
    g = (np.arange(7) - 3) * PAD_MM / 7
    return int((np.hypot(*np.meshgrid(g, g)) <= radius_mm + FIELD_MM + 1e-12).sum())


def place_of(area_mm2):
    return (np.cbrt(area_mm2) - 1) / (np.cbrt(100.0) - 1)


def pieces(objective):
    """Stretches of areas, as places, with the receptors that each reaches."""
    if objective != "Stimulus":
        return [(0.0, 1.0, 1)]
    g = (np.arange(7) - 3) * PAD_MM / 7
    radii = np.unique(np.round(np.hypot(*np.meshgrid(g, g)), 12)) - FIELD_MM
    areas = [1.0, *(np.pi * r * r for r in radii if r > 0 and 1 < np.pi * r * r < 100), 100.0]
    return [(place_of(low), place_of(high), receptors(np.sqrt(low / np.pi)))
            for low, high in zip(areas, areas[1:])]


def value_and_slopes(function, x):
    """function(x) and its gradient by a complex step."""
    steps = x + 1e-40j * np.vstack([np.zeros(5), np.eye(5)])
    values = function(steps)
    return values[0].real, values[1:].imag / 1e-40


def best_of(objective, limit_mm, case, rng):
    power = objective == "SkinPower"
    w = 2 * np.pi * case.get("hertz", 225)

    def log_cost(x):
        xs2, _, Bs = motion(x, case)
        return -np.log(xs2 * Bs if power else xs2)

    def log_travel(x):
        return np.log(motion(x, case)[1] / (limit_mm * 1e-3)**2)

    best = (-np.inf, 0)
    for low, high, weight in pieces(objective):
        ends = np.array([[0, 1.0]] * 5)
        ends[4] = low, high
        if "Ma2" in case:
            ends[1, 0] = (case["Ma2"] - LOW[1]) / (HIGH[1] - LOW[1])
        points = ends[:, 0] + (ends[:, 1] - ends[:, 0]) * rng.random((20000, 5))
        points[::2, 4], points[::3, 3] = low, 0
        rank = log_cost(points) + 10 * np.maximum(0, log_travel(points))
        order = np.argsort(rank)
        starts = [*points[order[:4]], *points[order[4:400:100]]]
        for start in starts:
            found = minimize(lambda x: value_and_slopes(log_cost, x), start, jac=True, bounds=ends,
                             method="SLSQP", options={"ftol": 1e-16, "maxiter": 300},
                             constraints={"type": "ineq", "fun": lambda x: -log_travel(x[None])[0].real,
                                          "jac": lambda x: -value_and_slopes(log_travel, x)[1]})
            x = np.clip(found.x, ends[:, 0], ends[:, 1])
            if log_travel(x[None])[0] > 1e-9:
                continue
            xs2, _, Bs = (part[0] for part in motion(x[None], case))
            value = w * w * Bs * xs2 / 2 if power else weight * np.sqrt(xs2 / 2)
            if value > best[0] * (1 + 1e-7):
                best = (value, 1)
            elif value > best[0] * (1 - 1e-7):
                best = (max(value, best[0]), best[1] + 1)
    assert best[1] >= 2, (objective, limit_mm, case, best)
    return best[0]


def line(objective, limit_mm, case):
    best = best_of(objective, limit_mm, case, np.random.default_rng(3))
    fields = [limit_mm / 1000] + [case.get(name, 0) for name in ("volt", "hertz", "Ks", "Bs", "Ma2")]
    return f"    {{sim::Objective::k{objective}, {', '.join(f'{number:.6g}' for number in fields)}, {best:.10e}}},"


def header():
    lines = ["// Written by limited_reference.py; do not edit.", "// clang-format off", "#pragma once",
             "", '#include "sim/tuning/adapter_objective.h"', "", "namespace haptometer::tests {", "",
             "/// The largest objective with which the mover travels no further than a limit; 0 keeps",
             "/// what the thesis's problem has.",
             "struct LimitedCase {", "  sim::Objective objective;", "  double limit_m;",
             "  double amplitude_v, frequency_hz;", "  double skin_stiffness, skin_damping;",
             "  double least_skin_side_mass_kg;", "  double best;", "};",
             "inline constexpr LimitedCase kLimitedCases[] = {"]
    lines += [line(*case) for case in CASES]
    return "\n".join([*lines, "};", "", "}  // namespace haptometer::tests", ""])


def same(ours, kept):
    number = re.compile(r"[-+]?\d+\.\d{10}e[-+]\d+")
    (a,), (b,) = number.findall(ours), number.findall(kept)
    return number.sub("", ours) == number.sub("", kept) and abs(float(a) / float(b) - 1) <= RELATIVE


def check(cases):
    text = pathlib.Path(__file__).with_suffix(".h").read_text()
    kept = [row for row in text.splitlines() if row.startswith("    {sim::")]
    if len(kept) != len(CASES):
        print(f"limited_reference.h has {len(kept)} cases, its script {len(CASES)}")
        return 1
    for k in cases:
        ours = line(*CASES[k])
        if not same(ours, kept[k]):
            print(f"limited_reference.h has\n{kept[k]}\nand its script computes\n{ours}")
            return 1
    return 0


def main():
    if "--check-all" in sys.argv:
        return check(range(len(CASES)))
    if "--check" in sys.argv:
        return check((4, 15, 22))
    print(header(), end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())
