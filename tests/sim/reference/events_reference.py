#!/usr/bin/python3
"""Reference values of scenes with travel stops and with breaking contact, to 50 digits.

Written from the equations of motion of the bodies (see linear_reference.py) with
  rigid stops      xv - xa = gap: the two exchange momentum and part with e times their speed
  contact          the skin pushes with F0 + Ks xs + Bs vs; when that is gone the body flies under
                   F0 and the skin follows by itself, Bs xp' = -(F0 + Ks xp), until they meet
not from the program: states by the Taylor series of exp(G t) z, events by their sign on a grid of
31 us and then a secant rule, all in 50 digits and 15 more for what the series cancels.

  events_reference.py            print the header
  events_reference.py --check    compare with events_reference.h beside this file; 0 when equal
"""
import pathlib
import sys

try:
    import mpmath as mp
except ImportError as missing:
    print(f"skipped: {missing}; install python3-mpmath")
    sys.exit(77)

mp.mp.dps = 65
GRID = mp.mpf(1) / 32000
# Lindsay 2013, Tables 2.1 and 2.4; each rounded to a double first, as a program holds it
TEXTS = dict(Mv="1.4e-3", Mc="0.6e-3", Kv="2800", Bv="0.0322", Km="1", R="27", L="130e-6",
             Ma1="0.25e-3", Ma2="4.35e-3", Ka="8200", Ba="0.01", Ks="600", Bs="0.75")
C = {name: mp.mpf(float(text)) for name, text in TEXTS.items()}
W = 2 * mp.pi * 225
GAP, E, PRELOAD = mp.mpf(float("0.3e-3")), mp.mpf(float("0.5")), mp.mpf(float("0.07"))
# z: the seven states, the skin's own position, 1, sin, cos
XV, VV, XA, VA, XS, VS, I, XP, ONE, SIN, COS = range(11)


def generator(contact):
    g = mp.zeros(11)
    mc1 = C["Mc"] + C["Ma1"]
    g[SIN, COS], g[COS, SIN] = W, -W
    g[XV, VV] = g[XA, VA] = g[XS, VS] = 1
    g[I, I], g[I, VV], g[I, VA], g[I, SIN] = -C["R"] / C["L"], C["Km"] / C["L"], -C["Km"] / C["L"], 5 / C["L"]

    def pull(velocity, mass, here, there, stiffness, damping):
        for position, rate, sign in ((*here, -1), (*there, 1)):
            g[velocity, position] += sign * stiffness / mass
            g[velocity, rate] += sign * damping / mass

    pull(VV, C["Mv"], (XV, VV), (XA, VA), C["Kv"], C["Bv"])
    pull(VA, mc1, (XA, VA), (XV, VV), C["Kv"], C["Bv"])
    pull(VA, mc1, (XA, VA), (XS, VS), C["Ka"], C["Ba"])
    pull(VS, C["Ma2"], (XS, VS), (XA, VA), C["Ka"], C["Ba"])
    g[VV, I], g[VA, I] = -C["Km"] / C["Mv"], C["Km"] / mc1
    if contact:
        g[VS, XS] -= C["Ks"] / C["Ma2"]
        g[VS, VS] -= C["Bs"] / C["Ma2"]
        g[XP, VS] = 1
    else:
        g[VS, ONE] = PRELOAD / C["Ma2"]
        g[XP, XP], g[XP, ONE] = -C["Ks"] / C["Bs"], -PRELOAD / C["Bs"]
    return g


GENERATORS = {contact: generator(contact) for contact in (True, False)}
GRID_STEPS = {}


# the entries that are not zero, row by row: most are
SPARSE = {contact: [[(g[row, k], k) for k in range(11) if g[row, k] != 0] for row in range(11)]
          for contact, g in GENERATORS.items()}


def advance(z, contact, t):
    """exp(G t) z, in pieces over which the series of 2e5/s does not cancel more than ten digits."""
    pieces = int(t * 100000) + 1
    for _ in range(pieces):
        term = list(z)
        total = list(z)
        k = 0
        while k < 20 or max(map(abs, term)) > mp.mpf(10)**-62:
            k += 1
            h = t / pieces / k
            term = [h * mp.fdot((g, term[j]) for g, j in row) for row in SPARSE[contact]]
            total = [x + y for x, y in zip(total, term)]
        z = mp.matrix(total)
    return z


def grid_step(z, contact):
    if contact not in GRID_STEPS:
        columns = [advance(mp.matrix([int(k == j) for k in range(11)]), contact, GRID) for j in range(11)]
        GRID_STEPS[contact] = [[columns[j][i] for j in range(11)] for i in range(11)]
    # mp.fdot is some three times faster than the product of matrices
    return mp.matrix([mp.fdot(row, z) for row in GRID_STEPS[contact]])


def guards(z, contact, stops, unilateral):
    values = {}
    if stops:
        values["up"] = GAP - (z[XV] - z[XA])
        values["down"] = GAP + (z[XV] - z[XA])
    if unilateral:
        values["contact"] = PRELOAD + C["Ks"] * z[XS] + C["Bs"] * z[VS] if contact else z[XP] - z[XS]
    return values


def collide(z):
    mc1 = C["Mc"] + C["Ma1"]
    impulse = (1 + E) * (z[VV] - z[VA]) / (1 / C["Mv"] + 1 / mc1)
    z[VV] -= impulse / C["Mv"]
    z[VA] += impulse / mc1
    return z


def first_event(z, contact, span, known):
    """(guard, time) of the first guard that ends below zero over `span` and did not just fire."""
    end = grid_step(z, contact) if span == GRID else advance(z, contact, span)
    found = []
    before, after = (guards(x, contact, **known) for x in (z, end))
    for name in after:
        if after[name] >= 0:
            continue
        low, high = mp.mpf(0), span
        if before[name] <= mp.mpf(10)**-50:  # it begins at zero: beyond what keeps it positive
            low = span / 1000
        g = lambda t: guards(advance(z, contact, t), contact, **known)[name]
        found.append((mp.findroot(g, (low, high), solver="anderson", tol=mp.mpf(10)**-100), name))
    return end, min(found) if found else None


def run(duration, stops, unilateral):
    known = dict(stops=stops, unilateral=unilateral)
    z, t, contact, events = mp.matrix([0] * 8 + [1, 0, 1]), mp.mpf(0), True, []
    span = GRID
    while t < duration - mp.mpf(10)**-40:
        span = (mp.floor(t / GRID + mp.mpf(10)**-30) + 1) * GRID - t
        if abs(span - GRID) < mp.mpf(10)**-40:
            span = GRID
        end, event = first_event(z, contact, span, known)
        if event is None:
            z, t = end, t + span
            continue
        tau, name = event
        z, t = advance(z, contact, tau), t + tau
        events.append(t)
        if name == "contact":
            contact = not contact
            if not contact:
                z[XP] = z[XS]
        else:
            z = collide(z)
    return z, events


def doubles(values):
    return ",\n    ".join(mp.nstr(value, 20, min_fixed=1, max_fixed=0) for value in values)


def header():
    lines = ["// Written by events_reference.py; do not edit.", "// clang-format off", "#pragma once", "",
             "namespace haptometer::tests {", ""]
    for name, duration, stops, unilateral in (("Stops", mp.mpf(1) / 32, True, False),
                                              ("Contact", mp.mpf(1) / 32, False, True),
                                              ("Both", mp.mpf(1) / 32, True, True)):
        z, events = run(duration, stops, unilateral)
        lines += [f"/// Adapter scene over {mp.nstr(duration, 10)} s: events in s, states at the end.",
                  f"inline constexpr double k{name}EventsS[] = {{", f"    {doubles(events)}}};",
                  f"inline constexpr double k{name}State[7] = {{",
                  f"    {doubles(z[k] for k in range(7))}}};", ""]
    lines += ["}  // namespace haptometer::tests", ""]
    return "\n".join(lines)


def main():
    path = pathlib.Path(__file__).with_suffix(".h")
    text = header()
    if "--check" not in sys.argv:
        print(text, end="")
        return 0
    same = path.read_text() == text
    print("equal" if same else f"{path} differs; run {pathlib.Path(__file__).name} > {path}")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
