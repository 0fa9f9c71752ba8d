#!/usr/bin/python3
"""RMS of the skin over the last ten periods of linear runs, to 20 digits, as a C++ header.

Written from the equations of motion (J. Lindsay, "A Mechanical Amplifier for Haptic Feedback",
University of Washington, 2013, equations 2.1-2.4), not from the program: eigenvalues and
eigenvectors with 60 digits, and the integral of each product of two exponentials in closed form.
The scenes are drawn over decades (seed 5), so that some adapters keep the skin a billionth as
large as the mover; every second one has an offset, a start and a grip.

  window_reference.py            print the header
  window_reference.py --check    compare with window_reference.h beside this file; 0 when equal
"""
import pathlib
import random
import sys

try:
    import mpmath as mp
except ImportError as missing:
    print(f"skipped: {missing}; install python3-mpmath")
    sys.exit(77)

mp.mp.dps = 60

# least and largest of each number, drawn evenly in the logarithm
RANGES = dict(Mv=(1e-5, 1), Mc=(1e-5, 1), Kv=(10, 1e6), Bv=(1e-5, 10), Km=(0.01, 100),
              R=(0.1, 1000), L=(1e-6, 0.1), Ma1=(1e-5, 0.1), Ma2=(1e-5, 0.1), Ka=(10, 1e6),
              Ba=(1e-5, 1), Ks=(10, 1e5), Bs=(1e-3, 50), f=(30, 2000), A=(0.1, 10))
START = dict(V0=0.4, xv=5e-5, vs=-0.03, i=0.02, Kg=120.0, Bg=0.4)
DURATION_S = 0.4


def drawn(number, generator):
    scene = {}
    for name, (least, most) in RANGES.items():
        share = generator.random()
        scene[name] = float(f"{least * (most / least) ** share:.6g}")
    scene.update(START if number % 2 else dict.fromkeys(START, 0.0))
    return scene


def window_rms(scene):
    """sqrt of the mean of xs^2 over [T - 10/f, T], the drive V0 + A sin(2 pi f t)."""
    c = {name: mp.mpf(value) for name, value in scene.items()}
    case = c["Mc"] + c["Ma1"]
    a = mp.zeros(7)  # xv, vv, xa, va, xs, vs, i
    a[0, 1] = a[2, 3] = a[4, 5] = 1
    for column, value in enumerate((-c["Kv"], -c["Bv"], c["Kv"], c["Bv"])):
        a[1, column] = value / c["Mv"]
        a[3, column] = -value / case
    a[1, 6], a[3, 6] = -c["Km"] / c["Mv"], c["Km"] / case
    a[3, 2] -= (c["Ka"] + c["Kg"]) / case
    a[3, 3] -= (c["Ba"] + c["Bg"]) / case
    a[3, 4], a[3, 5] = c["Ka"] / case, c["Ba"] / case
    a[5, 2], a[5, 3] = c["Ka"] / c["Ma2"], c["Ba"] / c["Ma2"]
    a[5, 4], a[5, 5] = -(c["Ka"] + c["Ks"]) / c["Ma2"], -(c["Ba"] + c["Bs"]) / c["Ma2"]
    a[6, 6], a[6, 1], a[6, 3] = -c["R"] / c["L"], c["Km"] / c["L"], -c["Km"] / c["L"]
    b = mp.zeros(7, 1)
    b[6] = 1 / c["L"]
    omega = 2 * mp.pi * c["f"]
    driven = mp.lu_solve(mp.mpc(0, omega) * mp.eye(7) - a, c["A"] * b)
    constant = mp.lu_solve(-a, c["V0"] * b)
    start = mp.matrix([c["xv"], 0, 0, 0, 0, c["vs"], c["i"]])
    values, vectors = mp.eig(a)
    free = mp.lu_solve(vectors, start - constant - driven.apply(mp.im))
    rates = list(values) + [mp.mpc(0, omega), mp.mpc(0, -omega), mp.mpc(0)]
    parts = [vectors[4, k] * free[k] for k in range(7)]
    parts += [driven[4] / mp.mpc(0, 2), mp.conj(driven[4] / mp.mpc(0, 2)), constant[4]]
    end = mp.mpf(DURATION_S)
    begin = end - 10 / c["f"]
    integral = mp.mpc(0)
    for x, p in zip(parts, rates):
        for y, q in zip(parts, rates):
            rate = p + q
            if abs(rate) < mp.mpf(10) ** -40:
                integral += x * y * (end - begin)
            else:
                integral += x * y * (mp.exp(rate * end) - mp.exp(rate * begin)) / rate
    return mp.sqrt(integral.real / (end - begin))


def header():
    names = list(RANGES) + list(START)
    out = ["// Written by window_reference.py; do not edit.", "// clang-format off", "#pragma once",
           "", "namespace haptometer::tests {", "",
           f"inline constexpr double kWindowRunS = {DURATION_S};", "struct WindowReference {",
           f"  double {', '.join(names)};", "  double rms_m;", "};",
           "inline constexpr WindowReference kWindowReferences[] = {"]
    generator = random.Random(5)
    for number in range(40):
        scene = drawn(number, generator)
        if scene["f"] * DURATION_S < 10:
            scene["f"] = 30.0
        numbers = ", ".join(f"{scene[name]:.17g}" for name in names)
        out.append(f"    {{{numbers}, {mp.nstr(window_rms(scene), 20)}}},")
    out += ["};", "", "}  // namespace haptometer::tests", ""]
    return "\n".join(out)


if __name__ == "__main__":
    text = header()
    if sys.argv[1:] == ["--check"]:
        kept = pathlib.Path(__file__).with_suffix(".h").read_text(encoding="utf-8")
        print("equal" if kept == text else "window_reference.h differs from what this script makes")
        sys.exit(0 if kept == text else 1)
    sys.stdout.write(text)
