# The ladders' scenes by SciPy: python3 - OUT CLASS METHOD RTOL reads this on its standard input and
# writes to OUT the seconds of the run, then the skin's displacement in m at each of its outputs.
# The equations of motion are those of docs/explanation/simulation.md, written for SciPy.
import sys
import time

import numpy
from scipy.integrate import solve_ivp

MV, MC, KV, BV, KM, R, L = 1.4e-3, 0.6e-3, 2800.0, 0.0322, 1.0, 27.0, 130e-6
MA1, MA2, KA, BA, KS, BS = 0.25e-3, 4.35e-3, 8200.0, 0.01, 600.0, 0.75
VOLT, OMEGA = 5.0, 2 * numpy.pi * 225
GAP, RESTITUTION, PRELOAD = 0.3e-3, 0.5, 0.07
CUBIC, HEAT_CAPACITY, THERMAL_RESISTANCE, PER_K = 3e9, 1e-3, 100.0, 3.93e-3
DURATION, OUTPUTS = 0.1, 1000
XV, VV, XA, VA, XS, VS, CURRENT, EIGHTH = range(8)


def rate(t, y, scene, contact):
    d, w = y[XV] - y[XA], y[VV] - y[VA]
    i, rise = y[CURRENT], 0.0
    spring = KV * d + BV * w
    if scene == "smooth":
        spring += CUBIC * d**3
        rise = y[EIGHTH]
    drop = R * (1 + PER_K * rise) * i
    joint = KA * (y[XA] - y[XS]) + BA * (y[VA] - y[VS])
    skin = KS * y[XS] + BS * y[VS] if contact else -PRELOAD
    eighth = 0.0
    if scene == "smooth":
        eighth = (drop * i - rise / THERMAL_RESISTANCE) / HEAT_CAPACITY
    elif scene == "contact" and not contact:
        eighth = -(PRELOAD + KS * y[EIGHTH]) / BS
    return [y[VV], -(KM * i + spring) / MV, y[VA], (KM * i + spring - joint) / (MC + MA1), y[VS],
            (joint - skin) / MA2, (VOLT * numpy.sin(OMEGA * t) - drop + KM * w) / L, eighth]


def event(function):
    """A function of the state that ends an integration where it falls through 0."""
    function.terminal, function.direction = True, -1
    return function


def events_of(scene, contact):
    if scene == "stops":
        return [event(lambda t, y: GAP - (y[XV] - y[XA])), event(lambda t, y: GAP + y[XV] - y[XA])]
    if scene != "contact":
        return []
    if contact:
        return [event(lambda t, y: PRELOAD + KS * y[XS] + BS * y[VS])]
    return [event(lambda t, y: y[EIGHTH] - y[XS])]


def after_event(scene, contact, y):
    if scene == "contact":
        if contact:
            y[EIGHTH] = y[XS]
        return not contact, y
    impulse = (1 + RESTITUTION) * (y[VV] - y[VA]) / (1 / MV + 1 / (MC + MA1))
    y[VV] -= impulse / MV
    y[VA] += impulse / (MC + MA1)
    return contact, y


def play(scene, method, rtol):
    outputs = numpy.arange(OUTPUTS + 1) * (DURATION / OUTPUTS)
    scale = [1e-4, 0.1, 1e-4, 0.1, 1e-4, 0.1, 0.1, 1.0]
    t, y, contact, shown = 0.0, numpy.zeros(8), True, []
    while t < DURATION:
        part = solve_ivp(lambda t, y: rate(t, y, scene, contact), (t, DURATION), y, method=method,
                         rtol=rtol, atol=[rtol * s for s in scale], dense_output=True,
                         events=events_of(scene, contact) or None)
        ahead = outputs[len(shown):]
        shown.extend(part.sol(ahead[ahead <= part.t[-1]])[XS])
        t, y = part.t[-1], part.y[:, -1].copy()
        if t < DURATION:
            contact, y = after_event(scene, contact, y)
    return shown


def main():
    out, scene, method, rtol = sys.argv[1:]
    begin = time.perf_counter()
    shown = play(scene, method, float(rtol))
    seconds = time.perf_counter() - begin
    with open(out, "w", encoding="ascii") as file:
        print(*[seconds, *shown], sep="\n", file=file)


main()
