#!/usr/bin/python3
"""Reference values of the adapter scene with a stiffening spring and a coil that heats, by SciPy.

Written from the equations of motion of the bodies (see linear_reference.py), with
  spring    Kv d + K3 ((d + s)^3 - s^3) between mover and case, d = xv - xa
  coil      R = R0 (1 + alpha theta), C theta' = R i^2 - theta / Rth
  stops     rigid: where xv - xa reaches the gap the two part with e times their speed
  contact   the skin pushes with F0 + Ks xs + Bs vs; when that is gone the body flies under F0 and
            the skin follows by itself until they meet
not from the program. DOP853 at rtol 1e-13; events by a secant rule on integrations from the step's
beginning, not on its interpolant. Radau, an implicit method, confirms the first scene to 1e-7.

  smooth_reference.py            print the header
  smooth_reference.py --check    compare with smooth_reference.h beside this file; 0 when within 3e-11
"""
import pathlib
import re
import sys

try:
    import numpy as np
    from scipy.integrate import DOP853, solve_ivp
except ImportError as missing:
    print(f"skipped: {missing}; install python3-scipy")
    sys.exit(77)

Mv, Mc, Kv, Bv, Km, R, L = 1.4e-3, 0.6e-3, 2800, 0.0322, 1, 27, 130e-6
Ma1, Ma2, Ka, Ba, Ks, Bs = 0.25e-3, 4.35e-3, 8200, 0.01, 600, 0.75
K3, SAG = 3e9, 5e-5
ALPHA, C, RTH = 3.93e-3, 1e-3, 100
GAP, E, PRELOAD = 0.3e-3, 0.5, 0.07
W = 2 * np.pi * 225
DURATION = 1 / 32
SCALE = np.array([0.2, 1e-3, 1, 1e-4, 0.1, 3e-4, 0.4, 10, 3e-4])


def rate(t, y, contact=True):
    i, xv, vv, xa, va, xs, vs, theta, xp = y
    resistance = R * (1 + ALPHA * theta)
    d = xv - xa
    spring = Kv * d + K3 * ((d + SAG) ** 3 - SAG ** 3) + Bv * (vv - va)
    joint = Ka * (xa - xs) + Ba * (va - vs)
    skin = Ks * xs + Bs * vs if contact else -PRELOAD
    return np.array([
        (5 * np.sin(W * t) - resistance * i + Km * (vv - va)) / L,
        vv, (-Km * i - spring) / Mv,
        va, (Km * i + spring - joint) / (Mc + Ma1),
        vs, (joint - skin) / Ma2,
        (resistance * i * i - theta / RTH) / C,
        vs if contact else -(PRELOAD + Ks * xp) / Bs])


def advance(t0, y, t1, contact):
    if t1 <= t0:
        return y
    return solve_ivp(rate, (t0, t1), y, "DOP853", rtol=1e-13, atol=1e-15 * SCALE, args=(contact,)).y[:, -1]


def guards(y, contact, stops, unilateral):
    values = {}
    if stops:
        values["up"], values["down"] = GAP - (y[1] - y[3]), GAP + (y[1] - y[3])
    if unilateral:
        values["contact"] = PRELOAD + Ks * y[5] + Bs * y[6] if contact else y[8] - y[5]
    return values


def locate(t0, y0, t1, contact, g):
    """The root of g between a step's ends, by regula falsi (Illinois)."""
    a, b, ga, gb = t0, t1, g(y0), g(advance(t0, y0, t1, contact))
    for _ in range(60):
        t = b - gb * (b - a) / (gb - ga)
        y = advance(t0, y0, t, contact)
        gt = g(y)
        if (gt < 0) == (gb < 0):
            b, gb, ga = t, gt, ga / 2
        else:
            a, ga, b, gb = b, gb, t, gt
        if abs(b - a) < 1e-17 or abs(gt) < 1e-17:
            break
    return t, y


def step_to_event(t, y, contact, known):
    """Steps until a guard falls or the end is reached: (time, state, guard or None)."""
    solver = DOP853(lambda u, z: rate(u, z, contact), t, y, DURATION, rtol=1e-13, atol=1e-15 * SCALE, max_step=2e-5)
    first = True
    while solver.status == "running":
        t0, y0 = solver.t, solver.y.copy()
        solver.step()
        before, after = guards(y0, contact, **known), guards(solver.y, contact, **known)
        for name, value in after.items():
            # what an event has just left at zero has risen after the first step, or rises
            if value < 0 and before[name] > 0 and not (first and before[name] < 1e-12):
                return *locate(t0, y0, solver.t, contact, lambda z, n=name: guards(z, contact, **known)[n]), name
        first = False
    return DURATION, solver.y, None


def run(stops, unilateral):
    known = dict(stops=stops, unilateral=unilateral)
    t, y, contact, events = 0.0, np.zeros(9), True, []
    while True:
        t, y, name = step_to_event(t, y, contact, known)
        if name is None:
            return y[:8], events
        events.append(t)
        if name == "contact":
            contact = not contact
            if not contact:
                y[8] = y[5]
        else:
            impulse = (1 + E) * (y[2] - y[4]) / (1 / Mv + 1 / (Mc + Ma1))
            y[2] -= impulse / Mv
            y[4] += impulse / (Mc + Ma1)


def results():
    smooth, _ = run(False, False)
    radau = solve_ivp(rate, (0, DURATION), np.zeros(9), "Radau", rtol=1e-9, atol=1e-10 * SCALE).y[:8, -1]
    apart = np.max(np.abs(smooth - radau) / SCALE[:8])
    assert apart < 1e-7, f"Radau differs by {apart}"
    return {"Smooth": (smooth, []), "SmoothStops": run(True, False), "SmoothContact": run(False, True)}


def header(found):
    def array(kind, values):
        return [f"inline constexpr double {kind}[] = {{", "    " + ",\n    ".join(f"{v:.17g}" for v in values) + "};"]
    lines = ["// Written by smooth_reference.py; do not edit.", "// clang-format off", "#pragma once", "",
             "namespace haptometer::tests {", "",
             "/// Adapter scene with stiffening spring and coil heating over 1/32 s from rest: events in s; at",
             "/// the end current, xv, vv, xa, va, xs, vs, and the coil's rise in K."]
    for name, (state, events) in found.items():
        if events:
            lines += array(f"k{name}EventsS", events)
        lines += array(f"k{name}State", state)
    return "\n".join(lines + ["", "}  // namespace haptometer::tests", ""])


def main():
    path = pathlib.Path(__file__).with_suffix(".h")
    text = header(results())
    if "--check" not in sys.argv:
        print(text, end="")
        return 0
    # SciPy's rounding may differ from machine to machine
    new, old = (np.array([float(v) for v in re.findall(r"^ +([-\d.e]+)", t, re.M)]) for t in (text, path.read_text()))
    same = new.size == old.size and bool(np.all(np.abs(new - old) <= 3e-11 * np.maximum(np.abs(old), 1e-6)))
    print("equal" if same else f"{path} differs; run {pathlib.Path(__file__).name} > {path}")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
