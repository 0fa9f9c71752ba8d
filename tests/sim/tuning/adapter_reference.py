#!/usr/bin/python3
"""Reference values of tuning: the thesis's grid by brute force, the optima to 30 digits.

Written from the equations of motion (J. Lindsay, "A Mechanical Amplifier for Haptic Feedback",
University of Washington, 2013, equations 2.1-2.4, with the reaction +Km i on the case), not from the
program:
  grid     all 20^5 points of Table 2.2 with NumPy, each evaluated, none left out by argument; the
           formula that does it is compared at random points with a solution of the four phasor
           equations
  optima   roots of the gradient in the numbers that are within their bounds, by mpmath; the others
           are at the bound to which their derivative points, which is checked
  stimulus receptors counted one by one

  adapter_reference.py            print the header
  adapter_reference.py --check    compare with adapter_reference.h beside this file; 0 when equal
"""
import pathlib
import sys

try:
    import mpmath as mp
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing}; install python3-mpmath and python3-numpy")
    sys.exit(77)

mp.mp.dps = 40

MV, MC, KV, BV, KM, R, L = 1.4e-3, 0.6e-3, 2800, 0.0322, 1, 27, 130e-6
VOLT, HERTZ = 5, 225
AXES = {"Ma1": (0.25e-3, 10e-3), "Ma2": (0.25e-3, 10e-3), "Ka": (2000, 12000), "Ba": (0.01, 0.1),
        "A": (1e-6, 100e-6)}
ORDER = ("Ma1", "Ma2", "Ka", "Ba", "A")
PAD_MM, FIELD_MM = 15, 5.7


def skin(area, root, K_max=2000):
    """Ks and Bs under an area, `root` the cube root."""
    low, high = root(1e-6), root(100e-6)
    part = (root(area) - low) / (high - low)
    return 600 + (K_max - 600) * part, 0.75 + 1.63 * part


def phasors(s, Ma1, Ma2, Ka, Ba, Ks, Bs):
    """The four phasor equations of i, xv, xa, xs."""
    return [[R + L * s, -KM * s, KM * s, 0],
            [KM, MV * s**2 + BV * s + KV, -(BV * s + KV), 0],
            [-KM, -(BV * s + KV), (MC + Ma1) * s**2 + (BV + Ba) * s + KV + Ka, -(Ba * s + Ka)],
            [0, 0, -(Ba * s + Ka), Ma2 * s**2 + (Ba + Bs) * s + Ka + Ks]]


def all_rms(Ma1, Ma2, Ka, Ba, Ks, Bs):
    """RMS of xs by elimination from the coil outwards; arrays that broadcast."""
    s = 2j * np.pi * HERTZ
    coil = R + L * s
    spring = BV * s + KV + KM**2 * s / coil  # between mover and case, the coil's back EMF in it
    mover = MV * s**2 + spring
    case = (MC + Ma1) * s**2 + spring - spring**2 / mover
    push = KM * VOLT / coil * (1 - spring / mover)
    link = Ka + Ba * s
    contact = Ma2 * s**2 + Ks + Bs * s
    return np.abs(push * link / ((case + link) * (contact + link) - link**2)) / np.sqrt(2)


def receptors(radius_mm, spacing_mm):
    g = (np.arange(7) - 3) * spacing_mm
    return int((np.hypot(*np.meshgrid(g, g)) <= radius_mm + FIELD_MM + 1e-12).sum())


def check_elimination():
    rng = np.random.default_rng(1)
    for _ in range(200):
        point = {name: rng.uniform(*AXES[name]) for name in ORDER}
        Ks, Bs = skin(np.array(point.pop("A")), np.cbrt)
        m = np.array(phasors(2j * np.pi * HERTZ, Ks=Ks, Bs=Bs, **point))
        exact = abs(np.linalg.solve(m, [VOLT, 0, 0, 0])[3]) / np.sqrt(2)
        assert abs(all_rms(Ks=Ks, Bs=Bs, **point) / exact - 1) < 1e-11


def grid_best(weight):
    """Index of the best point on each axis and its RMS; weight: one number an area."""
    axis = {name: np.linspace(*AXES[name], 20) for name in ORDER}
    best = (-1.0, None, None)
    for k in range(20):
        Ks, Bs = skin(axis["A"][k:k + 1], np.cbrt)
        rms = all_rms(axis["Ma1"][:, None, None, None], axis["Ma2"][None, :, None, None],
                      axis["Ka"][None, None, :, None], axis["Ba"][None, None, None, :], Ks, Bs)
        at = np.unravel_index(rms.argmax(), rms.shape)
        if weight[k] * rms[at] > best[0]:
            best = (weight[k] * rms[at], [*map(int, at), k], rms[at])
    return best[1], best[2]


def objectives(x):
    """RMS, power into the skin and RMS per watt of a dictionary of mpf."""
    s = mp.mpc(0, 2 * mp.pi * HERTZ)
    Ks, Bs = skin(x["A"], mp.cbrt)
    point = {name: x[name] for name in ("Ma1", "Ma2", "Ka", "Ba")}
    i, _, _, xs = mp.lu_solve(mp.matrix(phasors(s, Ks=Ks, Bs=Bs, **point)),
                              mp.matrix([VOLT, 0, 0, 0]))
    rms = abs(xs) / mp.sqrt(2)
    return rms, (2 * mp.pi * HERTZ)**2 * Bs * rms**2, rms / (VOLT * mp.re(i) / 2)


def optimum(which, free, held):
    """Maximum of objectives()[which] over the `free` names from where they start."""
    names = list(free)

    def at(*values):
        x = {name: mp.mpf(value) for name, value in held.items()}
        x.update((name, mp.mpf(free[name]) * value) for name, value in zip(names, values))
        return mp.log(objectives(x)[which])

    ones = [mp.mpf(1)] * len(names)
    def gradient(*values):
        return [mp.diff(at, values, tuple(int(k == j) for k in range(len(names))))
                for j in range(len(names))]
    root = mp.findroot(gradient, ones, tol=1e-40) if len(names) > 1 else [
        mp.findroot(lambda v: gradient(v)[0], ones[0], tol=1e-40)]
    found = {name: mp.mpf(value) for name, value in held.items()}
    found.update((name, mp.mpf(free[name]) * value) for name, value in zip(names, root))
    check_bounds(which, found, held)
    return found


def travel(x):
    """|xv - xa| of a dictionary of mpf."""
    Ks, Bs = skin(x["A"], mp.cbrt)
    point = {name: x[name] for name in ("Ma1", "Ma2", "Ka", "Ba")}
    _, xv, xa, _ = mp.lu_solve(mp.matrix(phasors(mp.mpc(0, 2 * mp.pi * HERTZ), Ks=Ks, Bs=Bs, **point)),
                               mp.matrix([VOLT, 0, 0, 0]))
    return abs(xv - xa)


def limited_optimum(limit, free, held):
    """The largest RMS where the mover travels by `limit`: stationary along that curve of (Ma2, Ka)."""
    def at(v):
        x = {name: mp.mpf(value) for name, value in held.items()}
        x.update((name, mp.mpf(value) * factor) for (name, value), factor in zip(free.items(), v))
        return x

    def equations(*v):
        def slope(function, k):
            return mp.diff(lambda t: function(at(v[:k] + (t,) + v[k + 1:])), v[k])
        def rms(x):
            return mp.log(objectives(x)[0])
        across = slope(rms, 0) * slope(travel, 1) - slope(rms, 1) * slope(travel, 0)
        return [across, travel(at(v)) / mp.mpf(limit) - 1]

    found = at(tuple(mp.findroot(equations, (mp.mpf(1), mp.mpf(1)), tol=1e-25)))
    # the held numbers: moved off their bounds, with Ka following to keep the travel, it gets worse
    for name in held:
        moved = dict(found)
        moved[name] = found[name] * mp.mpf("1.0001")
        moved["Ka"] = mp.findroot(lambda k: travel(dict(moved, Ka=k)) - mp.mpf(limit), found["Ka"])
        assert objectives(moved)[0] < objectives(found)[0], name
    return found


def check_bounds(which, found, held):
    """A held number lies at the bound beyond which the objective would grow."""
    for name, value in held.items():
        if value not in AXES[name]:
            continue
        sign = 1 if value == AXES[name][1] else -1
        moved = dict(found)
        moved[name] = found[name] * (1 - sign * mp.mpf("1e-6"))
        assert objectives(moved)[which] < objectives(found)[which], name


def header():
    check_elimination()
    areas = np.linspace(*AXES["A"], 20)
    lines = ["// Written by adapter_reference.py; do not edit.", "// clang-format off", "#pragma once",
             "", "namespace haptometer::tests {", "",
             "// the best of all 3 200 000 points: places on the axes Ma1, Ma2, Ka, Ba, A; RMS"]
    for name, weight in (
            ("Grid", np.ones(20)),
            ("StimulusGrid", [receptors(np.sqrt(a / np.pi) * 1e3, PAD_MM / 7) for a in areas])):
        places, rms = grid_best(weight)
        lines.append(f"inline constexpr int k{name}Places[5] = {{{', '.join(map(str, places))}}};")
        lines.append(f"inline constexpr double k{name}RmsM = {rms:.12e};")
    lines += ["", "// optima over the continuous bounds, to 20 digits"]
    step_mm = mp.sqrt(13) * PAD_MM / 7 - mp.mpf(FIELD_MM)  # the receptors at (2, 3) spacings
    step = mp.pi * (step_mm / 1000)**2
    rows = (("Rms", 0, {"Ma2": 4.92e-3, "Ka": 9276}, {"Ma1": 0.25e-3, "Ba": 0.01, "A": 1e-6}),
            ("Stimulus", 0, {"Ma1": 1.7e-3, "Ma2": 6.53e-3}, {"Ka": 12000, "Ba": 0.01, "A": step}),
            ("Power", 1, {"Ma2": 6.47e-3, "A": 10.3e-6}, {"Ma1": 0.25e-3, "Ka": 12000, "Ba": 0.01}),
            ("PerWatt", 2, {"Ma2": 6.3e-3}, {"Ma1": 0.25e-3, "Ka": 12000, "Ba": 0.01, "A": 1e-6}))
    for name, which, free, held in rows:
        found = optimum(which, free, held)
        for symbol in ORDER:
            lines.append(f"inline constexpr double k{name}Best{symbol} = {mp.nstr(found[symbol], 20)};")
        lines.append(f"inline constexpr double k{name}Best = {mp.nstr(objectives(found)[which], 20)};")
    lines += ["", "// the largest RMS with a mover's travel of 0.4 mm; Ma1, Ba and A at their lower bounds"]
    held = {"Ma1": 0.25e-3, "Ba": 0.01, "A": 1e-6}
    found = limited_optimum(0.4e-3, {"Ma2": 2.6963e-3, "Ka": 4798.9}, held)
    for symbol in ("Ma2", "Ka"):
        lines.append(f"inline constexpr double kLimitedBest{symbol} = {mp.nstr(found[symbol], 20)};")
    lines.append(f"inline constexpr double kLimitedBest = {mp.nstr(objectives(found)[0], 20)};")
    return "\n".join([*lines, "", "}  // namespace haptometer::tests", ""])


def main():
    text = header()
    if "--check" not in sys.argv:
        print(text, end="")
        return 0
    kept = pathlib.Path(__file__).with_suffix(".h").read_text()
    if kept != text:
        print("adapter_reference.h differs from what its script computes")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
