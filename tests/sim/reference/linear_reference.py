#!/usr/bin/python3
"""Reference values of the linear scenes, to 50 digits, printed with 20 as a C++ header.

Written from the equations of motion (J. Lindsay, "A Mechanical Amplifier for Haptic Feedback",
University of Washington, 2013, equations 2.1-2.4, with the reaction +Km i on the case that matrix
2.5 has), not from the program:
  steady state     the phasor equations of the coil and the three bodies, as second-order equations
  time response    eigenvalues and eigenvectors, every exponential in closed form
  window RMS       the integral of that closed form, term by term
and a second time, from scratch, by SciPy's Radau integrator with the drive as a forcing function.

  linear_reference.py            print the header
  linear_reference.py --check    compare with linear_reference.h beside this file; 0 when equal
"""
import pathlib
import sys

try:
    import mpmath as mp
    import numpy as np
    from scipy.integrate import solve_ivp
except ImportError as missing:
    print(f"skipped: {missing}; install python3-mpmath and python3-scipy")
    sys.exit(77)

mp.mp.dps = 50

# Lindsay 2013, Table 2.1 and Table 2.4; decimal strings, so that nothing is rounded before 50 digits
ACTUATOR = dict(Mv="1.4e-3", Mc="0.6e-3", Kv="2800", Bv="0.0322", Km="1", R="27", L="130e-6")
ADAPTER = dict(Ma1="0.25e-3", Ma2="4.35e-3", Ka="8200", Ba="0.01")
SCENES = {
    "Adapter": dict(**ACTUATOR, **ADAPTER, Ks="600", Bs="0.75"),
    "Cone": dict(**ACTUATOR, Ks="600", Bs="0.75"),
    "Direct": dict(**ACTUATOR, Ks="1861.2", Bs="2.2185"),
    "StiffMover": dict(**dict(ACTUATOR, Kv="1e11"), **ADAPTER, Ks="600", Bs="0.75"),
}
VOLT, HERTZ = mp.mpf(5), mp.mpf(225)
# Stiff movers beside a resonance without damping to speak of, where an ulp of w is 1e2 to 1e4 of the
# answer; the last one floats, and the inertia of 8 uHz is 1e-19 of its springs.
SHARP = [
    dict(Mv="1.85e-4", Mc="0.0387", Kv="1.97e5", Bv="0", Km="0.088", R="30.6", L="0", Ma1="0",
         Ma2="9.83e-5", Ka="4.43", Ba="0", Ks="600", Bs="3.06", Kg="0", V="2.97e-5", f="5200.6"),
    dict(Mv="1.95e-6", Mc="0.083", Kv="8.2e4", Bv="0", Km="1.11", R="3760", L="1.13", Ma1="0",
         Ma2="6.44e-6", Ka="9.92e5", Ba="0", Ks="0", Bs="1.64e-3", Kg="0", V="1.46e-4", f="32635"),
    dict(Mv="5.27e-6", Mc="0.673", Kv="7.79e6", Bv="0", Km="0.0222", R="229", L="1.38e-6", Ks="600",
         Bs="1.98e-5", Kg="57", V="3.54e-3", f="193300"),
    dict(Mv="2.46e-5", Mc="1.36", Kv="8.92e6", Bv="0", Km="0.804", R="332", L="0", Ks="600",
         Bs="0.0603", Kg="0", V="0.724", f="95845"),
    dict(Mv="2.9e-6", Mc="5.5e-4", Kv="3.5e6", Bv="554", Km="4.72e-4", R="213", L="0.164", Ma1="0",
         Ma2="3.1e-6", Ka="2300", Ba="0", Ks="0", Bs="0", Kg="0", V="1.67", f="8e-6"),
]
# Every constant is rounded to the nearest double first: the references are those of the numbers that
# a program can hold, so the last digits compare.
def constants(texts):
    return {name: mp.mpf(float(text)) for name, text in texts.items()}


def steady(texts):
    """Peak phasors (i, xv, xa, xs) for v = V at f, which are VOLT and HERTZ where not among texts."""
    c = dict(Kg=mp.mpf(0), V=VOLT, f=HERTZ) | constants(texts)
    s = mp.mpc(0, 2 * mp.pi * c["f"])
    motor = c["Kv"] + c["Bv"] * s
    if "Ka" in c:
        link = c["Ka"] + c["Ba"] * s
        case = (c["Mc"] + c["Ma1"]) * s**2 + motor + link + c["Kg"]
        skin = c["Ma2"] * s**2 + link + c["Ks"] + c["Bs"] * s
    else:
        # the case is the contact: tie xs to xa
        link, skin = mp.mpf(1), mp.mpf(1)
        case = c["Mc"] * s**2 + motor + c["Ks"] + c["Bs"] * s + link + c["Kg"]
    m = mp.matrix([
        [c["R"] + c["L"] * s, -c["Km"] * s, c["Km"] * s, 0],
        [c["Km"], c["Mv"] * s**2 + motor, -motor, 0],
        [-c["Km"], -motor, case, -link],
        [0, 0, -link, skin]])
    return mp.lu_solve(m, mp.matrix([c["V"], 0, 0, 0])), c


def summary(texts):
    (i, xv, xa, xs), c = steady(texts)
    force = abs((c["Ks"] + mp.mpc(0, 2 * mp.pi * c["f"]) * c["Bs"]) * xs)
    return dict(skin_rms_m=abs(xs) / mp.sqrt(2), mover_peak_m=abs(xv - xa),
                case_rms_m=abs(xa) / mp.sqrt(2), current_rms_a=abs(i) / mp.sqrt(2),
                power_w=c["V"] * mp.re(i) / 2, phase_rad=mp.arg(i), skin_force_peak_n=force)


def system(texts):
    """A and B of the seven states xv, vv, xa, va, xs, vs, i; without inductance i is none of them."""
    c = constants(texts)
    mc1 = c["Mc"] + c["Ma1"]
    n = 7 if c["L"] > 0 else 6
    a = mp.zeros(n, n)
    b = mp.zeros(n, 1)
    xv, vv, xa, va, xs, vs, i = range(7)

    def add(row, mass, column, value):
        a[row, column] += value / mass

    def force(body, mass, on, other, stiffness, damping):
        """The spring and damper between two bodies, or a body and ground, in the row of `body`."""
        add(body, mass, on[0], -stiffness)
        add(body, mass, on[1], -damping)
        if other:
            add(body, mass, other[0], stiffness)
            add(body, mass, other[1], damping)

    a[xv, vv] = a[xa, va] = a[xs, vs] = 1
    force(vv, c["Mv"], (xv, vv), (xa, va), c["Kv"], c["Bv"])
    force(va, mc1, (xa, va), (xv, vv), c["Kv"], c["Bv"])
    force(va, mc1, (xa, va), (xs, vs), c["Ka"], c["Ba"])
    force(vs, c["Ma2"], (xs, vs), (xa, va), c["Ka"], c["Ba"])
    force(vs, c["Ma2"], (xs, vs), None, c["Ks"], c["Bs"])
    if c["L"] == 0:
        # i = (v - Km (va - vv)) / R at once
        for row, mass, sign in ((vv, c["Mv"], -1), (va, mc1, 1)):
            add(row, mass, vv, sign * c["Km"]**2 / c["R"])
            add(row, mass, va, -sign * c["Km"]**2 / c["R"])
            b[row] = sign * c["Km"] / c["R"] / mass
        return a, b
    add(vv, c["Mv"], i, -c["Km"])
    add(va, mc1, i, c["Km"])
    add(i, c["L"], i, -c["R"])
    add(i, c["L"], vv, c["Km"])
    add(i, c["L"], va, -c["Km"])
    b[i] = 1 / c["L"]
    return a, b


class FromRest:
    """x(t) = sum_k c_k exp(lambda_k t): the transients and the two lines of the drive."""

    def __init__(self, texts):
        a, b = system(texts)
        eigenvalues, vectors = mp.eig(a)
        w = 2 * mp.pi * HERTZ
        n = a.rows
        phasor = mp.lu_solve(mp.mpc(0, w) * mp.eye(n) - a, VOLT * b)
        # Im(X e^jwt) = (X e^jwt - conj(X) e^-jwt) / 2j
        half = phasor / mp.mpc(0, 2)
        start = mp.lu_solve(vectors, -phasor.apply(mp.im))
        self.rates = list(eigenvalues) + [mp.mpc(0, w), mp.mpc(0, -w)]
        self.fastest = max(abs(e) for e in eigenvalues)
        self.weights = [[vectors[row, k] * start[k] for k in range(n)] +
                        [half[row], mp.conj(half[row])] for row in range(n)]
        if n == 6:
            c = constants(texts)
            ratio, volt = c["Km"] / c["R"], VOLT / c["R"] / mp.mpc(0, 2)
            # the current follows: i = (v + Km (vv - va)) / R
            self.weights.append([ratio * (v - a) for v, a in zip(self.weights[1], self.weights[3])])
            self.weights[6][6] += volt
            self.weights[6][7] -= volt

    def state(self, row, t):
        return mp.re(sum(c * mp.exp(r * t) for c, r in zip(self.weights[row], self.rates)))

    def window_rms(self, row, begin, end):
        total = mp.mpf(0)
        for c1, r1 in zip(self.weights[row], self.rates):
            for c2, r2 in zip(self.weights[row], self.rates):
                rate = r1 + r2
                part = end - begin if abs(rate) < mp.mpf(10)**-30 else \
                    (mp.exp(rate * end) - mp.exp(rate * begin)) / rate
                total += c1 * c2 * part
        return mp.sqrt(mp.re(total) / (end - begin))


class Burst:
    """From rest under a burst, mode by mode: c' = l c + beta (a + r tau) e^(j w s), piece by piece."""

    def __init__(self, texts, start, rise, hold, fall):
        a, b = system(texts)
        self.rates, self.vectors = mp.eig(a)
        self.drive = mp.lu_solve(self.vectors, VOLT * b)
        ends = [mp.mpf(float(start))]
        for length in (rise, hold, fall):
            ends.append(ends[-1] + mp.mpf(float(length)))
        # (begin, end, envelope at begin, its slope)
        self.pieces = [(ends[0], ends[1], 0, 1 / (ends[1] - ends[0])), (ends[1], ends[2], 1, 0),
                       (ends[2], ends[3], 1, -1 / (ends[3] - ends[2]))]

    def state(self, t):
        w = 2 * mp.pi * HERTZ
        out = []
        for rate, beta in zip(self.rates, self.drive):
            total = mp.mpc(0)
            for sign in (1, -1):
                # sin = (e^jws - e^-jws) / 2j, s from the burst's begin
                jw, weight = mp.mpc(0, sign * w), sign / mp.mpc(0, 2)
                for begin, end, level, slope in self.pieces:
                    if t <= begin:
                        continue
                    end = min(end, t)
                    q = slope / (jw - rate)
                    p = (level - q) / (jw - rate)
                    part = (p + q * (end - begin)) * mp.exp(jw * (end - self.pieces[0][0]))
                    part = part * mp.exp(rate * (t - end))
                    part -= p * mp.exp(jw * (begin - self.pieces[0][0]) + rate * (t - begin))
                    total += weight * beta * part
            out.append(total)
        return [mp.re(v) for v in self.vectors * mp.matrix(out)]


def moler():
    """C. Moler, "A Balancing Act for the Matrix Exponential", 2012: the matrix of that example."""
    a, b, c, d, e = map(mp.mpf, (2e10, 4e8 / 6, 200 / 3, 3.0, 1e-8))
    return mp.matrix([[0, e, 0], [mp.mpf(float(-(a + b))), -d, a], [c, 0, -c]])


def exponential(a, h):
    eigenvalues, vectors = mp.eig(a)
    scaled = vectors * mp.diag([mp.exp(e * h) for e in eigenvalues])
    return (scaled * mp.inverse(vectors)).apply(mp.re)


def by_radau(texts, begin, end):
    """The window RMS once more, in double precision by an ODE solver; the integral is a state."""
    a, b = system(texts)
    a = np.array(a.tolist(), dtype=float)
    b = np.array(b.tolist(), dtype=float).ravel()
    unit = np.array([1e-3, 1.0, 1e-3, 1.0, 1e-3, 1.0, 0.1, 1e-9])

    def rate(t, y):
        x = y[:7] * unit[:7]
        dx = a @ x + b * 5 * np.sin(2 * np.pi * 225 * t)
        return np.append(dx, x[4]**2) / unit

    first = solve_ivp(rate, (0, begin), np.zeros(8), method="Radau", rtol=1e-10, atol=1e-12)
    y = first.y[:, -1].copy()
    y[7] = 0
    last = solve_ivp(rate, (begin, end), y, method="Radau", rtol=1e-10, atol=1e-12)
    return float(np.sqrt(last.y[7, -1] * unit[7] / (end - begin)))


# what the adapter scene is changed into
HARD = {
    "130 uH": {}, "50 uH": dict(L="50e-6"), "10 uH": dict(L="10e-6"), "1 uH": dict(L="1e-6"),
    "no inductance": dict(L="0"),
    "Bv = 0": dict(Bv="0"), "Ba = 0": dict(Ba="0"), "Ks = 0": dict(Ks="0"),
    "L = Bv = Ba = Ks = 0": dict(L="0", Bv="0", Ba="0", Ks="0"),
    "skin's side 1e6 times the mover": dict(Ma2="1.4e3"),
    "skin's side 1e-6 of the mover": dict(Ma2="1.4e-9"),
    "skin's side 1e-6 of the mover, no inductance": dict(Ma2="1.4e-9", L="0"),
    "Kv = 1e11": dict(Kv="1e11"), "Ka = 1e11": dict(Ka="1e11"), "Ks = 1e11": dict(Ks="1e11"),
    # just below and above where rounding of the coil's forces begins to count, and the worst of it
    "Kv = 2e5": dict(Kv="2e5", L="0"), "Kv = 1e7": dict(Kv="1e7", L="0"),
    "Kv = 1e11, no inductance": dict(Kv="1e11", L="0"),
    "Kv = 1e11, Ks = 0": dict(Kv="1e11", Ks="0"),
}
CHANGED = dict(L="inductance_h", Kv="mover_stiffness_n_per_m", Bv="mover_damping_n_s_per_m",
               Ma2="skin_side_mass_kg", Ka="adapter_stiffness_n_per_m",
               Ba="adapter_damping_n_s_per_m", Ks="skin_stiffness_n_per_m")


def hard_cases():
    out = ["// the adapter scene with one thing or another changed: from rest, every 10 ms up to 0.1 s",
           "struct HardReference {", "  const char* name;"]
    out += [f"  double {key};" for key in CHANGED.values()]
    out += ["  double fastest_rad_per_s;  // largest eigenvalue", "  double states[10][7];", "};",
            "inline constexpr HardReference kHardReferences[] = {"]
    for name, change in HARD.items():
        texts = dict(SCENES["Adapter"], **change)
        response = FromRest(texts)
        values = ", ".join(texts[symbol] for symbol in CHANGED)
        out.append(f'    {{"{name}", {values}, {mp.nstr(response.fastest, 5)},')
        states = []
        for k in range(1, 11):
            at = mp.mpf(k) / 100
            states.append("{" + rows((response.state(row, at) for row in range(7)), 6).lstrip() + "}")
        out.append("     {" + ",\n      ".join(states) + "}},")
    return out + ["};", ""]


SHARP_FIELDS = dict(Mv="moving_mass_kg", Mc="case_mass_kg", Kv="mover_stiffness_n_per_m",
                    Bv="mover_damping_n_s_per_m", Km="force_constant_n_per_a", R="resistance_ohm",
                    L="inductance_h", Ma1="motor_side_mass_kg", Ma2="skin_side_mass_kg",
                    Ka="adapter_stiffness_n_per_m", Ba="adapter_damping_n_s_per_m",
                    Ks="skin_stiffness_n_per_m", Bs="skin_damping_n_s_per_m",
                    Kg="grip_stiffness_n_per_m", V="amplitude_v", f="frequency_hz")
SHARP_ANSWERS = ("skin_rms_m", "mover_peak_m", "case_rms_m", "current_rms_a", "power_w",
                 "skin_force_peak_n")


def sharp_scenes():
    out = ["// beside sharp resonances; without an adapter its numbers are 0", "struct SharpReference {"]
    out += [f"  double {name};" for name in (*SHARP_FIELDS.values(), *SHARP_ANSWERS)]
    out += ["};", "inline constexpr SharpReference kSharpReferences[] = {"]
    for texts in SHARP:
        answers = summary(texts)
        constants_of = ", ".join(texts.get(symbol, "0") for symbol in SHARP_FIELDS)
        out += [f"    {{{constants_of},", rows((answers[key] for key in SHARP_ANSWERS), 5) + "},"]
    return out + ["};", ""]


def number(value):
    return mp.nstr(value, 20, strip_zeros=False, min_fixed=0, max_fixed=0)


def rows(values, indent):
    return ",\n".join(" " * indent + number(v) for v in values)


def header():
    out = ["// Written by linear_reference.py; do not edit.", "// clang-format off", "#pragma once", "",
           "namespace haptometer::tests {", ""]
    for name, texts in SCENES.items():
        for key, value in summary(texts).items():
            words = "".join(w.capitalize() for w in key.split("_"))
            out.append(f"inline constexpr double k{name}{words} = {number(value)};")
        out.append("")

    out += sharp_scenes()
    adapter = FromRest(SCENES["Adapter"])
    begin, end = mp.mpf("0.1") - 10 / HERTZ, mp.mpf("0.1")
    rms = adapter.window_rms(4, begin, end)
    other = by_radau(SCENES["Adapter"], float(begin), float(end))
    assert abs(other / rms - 1) < 1e-8, (other, rms)
    out += ["// RMS of the skin over the last 10 periods of 0.1 s from rest, adapter scene",
            f"inline constexpr double kAdapterWindowRmsM = {number(rms)};", ""]
    stiff = FromRest(dict(SCENES["Adapter"], Kv="1e11")).window_rms(4, begin, end)
    out += ["// the same with a mover's spring of 1e11 N/m",
            f"inline constexpr double kStiffMoverWindowRmsM = {number(stiff)};", ""]

    out.append("// states at 0.0123 s from rest, adapter scene; the same with L = 10 uH and 1 uH")
    for name, inductance in (("", "130e-6"), ("10uH", "10e-6"), ("1uH", "1e-6")):
        response = FromRest(dict(SCENES["Adapter"], L=inductance))
        at = mp.mpf(float("0.0123"))
        states = rows((response.state(k, at) for k in range(7)), 4)
        out += [f"inline constexpr double kAdapterState{name}[7] = {{", states + "};"]
        # the same after 0.1 s, where rounding had a thousand steps to gather
        states = rows((response.state(k, mp.mpf(float("0.1"))) for k in range(7)), 4)
        out += [f"inline constexpr double kAdapterLater{name}[7] = {{", states + "};"]
    out.append("")
    out += hard_cases()
    out += ["// a burst: begins at 3.1 ms, rises over 7.1 ms, holds for 21.3 ms, falls over 5.1 ms; states",
            "// every 5 ms up to 50 ms", "inline constexpr double kBurstStates[10][7] = {"]
    burst = Burst(SCENES["Adapter"], "0.0031", "0.0071", "0.0213", "0.0051")
    out += ["    {" + rows(burst.state(mp.mpf(k) / 200), 5).lstrip() + "}," for k in range(1, 11)]
    out += ["};", ""]

    out += ["// exp(A h) of the adapter scene, row by row", "struct ExponentialReference {",
            "  double h_s;", "  double entries[49];", "};",
            "inline constexpr ExponentialReference kExponentials[] = {"]
    for h in ("1e-5", "1e-4", "1e-3", "1e-2", "1e-1"):
        e = exponential(system(SCENES["Adapter"])[0], mp.mpf(float(h)))
        out += [f"    {{{h}, {{", rows((e[r, c] for r in range(7) for c in range(7)), 8) + "}},"]
    e = exponential(moler(), mp.mpf(1))
    out += ["};", "", "// exp of Moler's matrix, row by row",
            "inline constexpr double kMolerExponential[9] = {",
            rows((e[r, c] for r in range(3) for c in range(3)), 4) + "};"]
    out += ["", "}  // namespace haptometer::tests", ""]
    return "\n".join(out)


if __name__ == "__main__":
    text = header()
    if sys.argv[1:] == ["--check"]:
        kept = pathlib.Path(__file__).with_suffix(".h").read_text(encoding="utf-8")
        print("equal" if kept == text else "linear_reference.h differs from what this script makes")
        sys.exit(0 if kept == text else 1)
    sys.stdout.write(text)
