"""Recordings and scenes of many kinds, drawn from seeds: what golden.py runs each verb on, beside the fixtures.

Each function writes a folder of files. Numbers are printed with few digits, so that each machine makes the same files.
What the verbs make of them is pinned, right or refused: no test says how right; those of the rooms do.
"""
import cmath
import math
import os
import pathlib
import random
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/long"), str(ROOT / "tests/sim/reference")]
import accuracies  # noqa: E402

G_M_PER_S2 = 9.80665


def tables(name, count, make):
    """`count` tables, each from random numbers of its own."""
    os.mkdir(name)
    for n in range(count):
        pathlib.Path(name, f"{n:02}.csv").write_text(make(random.Random(f"{name} {n}")))


def is_on(gates, t):
    return any(begin <= t < end for begin, end in gates)


def gates_of(draw, seconds):
    """When a drive is on: throughout, from a time on, in bursts, or never."""
    kind = draw.choice(["throughout"] * 4 + ["late", "bursts", "bursts", "never"])
    if kind == "throughout":
        return [(-1, seconds + 1)]
    if kind == "late":
        return [(seconds * draw.uniform(0.1, 0.5), seconds + 1)]
    length = draw.uniform(0.15, 0.6)
    return [] if kind == "never" else [(at, at + length) for at in
                                       (0.2 + 2 * length * n for n in range(int(seconds / 2 / length) + 1))]


def course_of(draw, seconds):
    """Relative amplitude by time: constant, drifting, decaying or in two levels."""
    kind, size = draw.choice(["constant", "constant", "drift", "decay", "step"]), draw.uniform(0.02, 0.6)
    return {"constant": lambda t: 1, "drift": lambda t: 1 + size * t / seconds, "decay": lambda t: math.exp(-size * t),
            "step": lambda t: 1 + size * (t > seconds / 2)}[kind]


def faults_of(draw, rows):
    """What befalls the readings: rows by the fault's name."""
    chosen = draw.choice([[], [], [], ["blank"], ["code"], ["spike"], ["held"], ["missing"], ["blank", "spike"]])
    return {name: {row + k for row in draw.sample(range(5, rows - 40), draw.choice([1, 5, 20]))
                   for k in range(draw.choice([1, 1, 3, 30]) if name != "spike" else 1)} for name in chosen}


def record(draw):
    """A laser's table: a tone that is switched, with tremor, hum, a second tone, noise, faults and a drive channel."""
    rate = draw.choice([1500, 2000, 4000, 5000, 10000, 20000])
    seconds = min(draw.uniform(0.7, 4), 16000 / rate)
    rows = int(rate * seconds)
    tone, amplitude = draw.uniform(30, min(480, rate / 5)), 10 ** draw.uniform(-0.5, 2.3)
    sweep = draw.choice([0, 0, 0, 0, draw.uniform(-20, 20)])
    others = [(frequency, amplitude * draw.uniform(*sizes)) for frequency, sizes, share in (
        (draw.uniform(6, 13), (1, 30), 0.6), (50, (0.01, 0.3), 0.25), (draw.uniform(25, 700), (0.01, 0.8), 0.3),
        (2 * tone, (0.01, 0.2), 0.3)) if draw.random() < share and frequency < rate / 2.5]
    gates, course, delay = gates_of(draw, seconds), course_of(draw, seconds), draw.choice([0, 0.02])
    noise, slope = amplitude * 10 ** draw.uniform(-3, -0.5), amplitude * draw.choice([0, draw.uniform(-5, 5)])
    digits = draw.choice([1, 2, 3, 4])
    limit = (amplitude + sum(size for _, size in others)) * draw.choice([1e9] * 9 + [0.8, 0.98])
    faults = faults_of(draw, rows)
    channel = draw.choice([None, None, "voltage_v", "trigger"])
    time_digits = draw.choice([4, 5, 6, 6, 7])
    held, lines = 0.0, ["time_s,displacement_um" + ("," + channel if channel else "")]
    for row in range(rows):
        t = row / rate
        phase = 2 * math.pi * (tone + sweep * t / 2) * t
        x = amplitude * course(t) * math.sin(phase) * is_on(gates, t - delay) + slope * t + draw.gauss(0, noise)
        x += sum(size * math.sin(2 * math.pi * frequency * t + frequency) for frequency, size in others)
        x = max(min(x, limit), -limit) + 30 * amplitude * (row in faults.get("spike", ()))
        held = held if row in faults.get("held", ()) else x
        text = f"{held:.{digits}f}" if row not in faults.get("code", ()) else "-99998"
        text = "" if row in faults.get("blank", ()) else text
        volts = 2 * math.sin(phase) if channel == "voltage_v" else 5
        drive = f",{volts * is_on(gates, t) + draw.gauss(0, 1e-3):.3f}" if channel else ""
        if row not in faults.get("missing", ()):
            lines.append(f"{t:.{time_digits}f},{text}{drive}")
    return "\n".join(lines) + "\n"


def drop(draw):
    """An actuator's voltage behind a drop or a released current, with hum, drift, a later blow and a converter."""
    mass, stiffness, km = draw.uniform(1e-3, 3e-3), draw.uniform(1500, 5000), draw.uniform(0.4, 2)
    load = draw.choice([math.inf, math.inf, 33, 100])
    decay = draw.uniform(4, 40) + (km**2 / (27 + load) / 2 / mass if load < math.inf else 0)
    height, rebound = draw.uniform(3e-3, 3e-2), draw.choice([0, 0, 0.2])
    pole = complex(-decay, math.sqrt(stiffness / mass - decay**2))
    first = km * math.sqrt(2 * G_M_PER_S2 * height) * (1 + rebound) * (load / (27 + load) if load < math.inf else 1)
    rate = draw.choice([2000, 5000, 10000])
    step = first * draw.choice([0, 1e-3, 8e-3])
    noise, offset = first * 10 ** draw.uniform(-4, -1.7), first * draw.uniform(-0.1, 0.1)
    hum, drift = first * draw.choice([0, 0, 0.02]), first * draw.choice([0, 0, 0.05])
    again, second = draw.choice([9, 9, draw.uniform(0.1, 0.3)]), draw.choice([0, 0, 0, 0.03])
    rail = first * draw.choice([9, 9, 9, 0.7])
    quiet, seconds = draw.choice([0, 0.02, 0.05]), draw.uniform(0.25, 0.7)
    known = [("moving_mass_kg", f"{mass:.7f}"), ("resistance_ohm", "27"), ("drop_height_m", f"{height:.5f}"),
             ("rebound", f"{rebound}"), ("inductance_h", "0.00013")]
    head = [f"# {key} = {value}" for key, value in known if draw.random() < 0.8]
    head += ["# case = held", f"# load_ohm = {load:g}", "time_s,voltage_v"]

    def ringing(t, size):
        if t < 0:
            return 0
        swing = cmath.exp(pole * t) * complex(1, pole.real / -pole.imag)
        return size * (swing.real + second * math.exp(-30 * t) * math.sin(2 * math.pi * 700 * t))

    rows = []
    for n in range(int((quiet + seconds) * rate)):
        t = n / rate - quiet
        v = ringing(t, first) + ringing(t - again, first / 3) + offset + drift * t + draw.gauss(0, noise)
        v = max(min(v + hum * math.sin(2 * math.pi * 50 * t), rail), -rail)
        rows.append(f"{t:.4f},{round(v / step) * step if step else v:.6f}")
    return "\n".join(head + rows) + "\n"


def impedance(draw):
    """A swept impedance of coil and moving mass, with noise and, at times, an outlier."""
    r, l, km = draw.uniform(10, 60), draw.uniform(5e-5, 8e-4), draw.uniform(0.4, 2)
    k, b, m = draw.uniform(1500, 5000), draw.uniform(0.01, 0.08), draw.uniform(1e-3, 3e-3)
    resonance = math.sqrt(k / m) / 2 / math.pi
    points, noise = draw.choice([12, 30, 80]), 10 ** draw.uniform(-4, -1.7)
    span, outlier = draw.choice([1.2, 1.5, 3]), draw.choice([-1, -1, -1, points // 2])
    lines = ["frequency_hz,impedance_ohm,phase_deg"]
    for n in range(points):
        f = resonance * span ** (2 * n / (points - 1) - 1)
        s = 2j * math.pi * f
        z = (r + s * l + s * km**2 / (k + m * s**2 + b * s)) * complex(1 + draw.gauss(0, noise), draw.gauss(0, noise))
        z *= 1.3 if n == outlier else 1
        lines.append(f"{f:.6g},{abs(z):.6g},{math.degrees(cmath.phase(z)):.4f}")
    return "\n".join(lines) + "\n"


def tap(draw):
    """The ringing of an adapter behind one tap or two, with noise, hum and steps of its readings."""
    rate, seconds = draw.choice([1000, 2000, 5000]), draw.uniform(0.5, 1.5)
    pole, size = complex(-draw.uniform(2, 30), 2 * math.pi * draw.uniform(60, 240)), 10 ** draw.uniform(-5, -3.3)
    noise, step = size * 10 ** draw.uniform(-4, -1.5), size * draw.choice([1e-6, 2e-3])
    again, hum, quiet = draw.choice([9, 9, 0.4]), size * draw.choice([0, 0, 0.01]), draw.choice([0, 0.1])
    lines = ["time_s,displacement_m"]
    for n in range(int(rate * seconds)):
        t = n / rate - quiet
        x = sum(size * part * cmath.exp(pole * at).real for part, at in ((1, t), (0.4, t - again)) if at >= 0)
        x += draw.gauss(0, noise) + hum * math.sin(2 * math.pi * 50 * t)
        lines.append(f"{t:.4f},{round(x / step) * step:.10f}")
    return "\n".join(lines) + "\n"


def printed_time(draw, style, digits):
    """How one time of a table is printed, in seconds or as its style has it."""
    start = draw.choice([0, 0, 0, -0.5, 12.25])
    day = draw.randrange(28)

    def seconds(t):
        return f"{t + start:.{digits}f}"

    def clock(t):
        return f"{13 + int(t) // 3600:02}:{int(t) // 60 % 60:02}:{t % 60:09.6f}"
    return {"s": seconds, "ms": lambda t: f"{1e3 * (t + start):.{max(digits - 3, 0)}f}",
            "exponent": lambda t: f"{t + start:.{digits}e}", "clock": clock,
            "date": lambda t: f"2024-03-{day + 1:02} {clock(t)}"}[style]


def table(draw):
    """A logger's table in one of many layouts; rows are missing, doubled or late, cells without a number."""
    rows, rate = draw.randrange(60, 700), draw.choice([50, 100, 1000, 3333, 5000, draw.uniform(40, 9000)])
    style = draw.choice(["s", "s", "s", "ms", "exponent", "clock", "date"])
    time = printed_time(draw, style, draw.choice([3, 4, 5, 6, 7, 9]))
    separator, comma, end = draw.choice([(",", False), (";", False), (";", True), ("\t", False), ("\t", True)]) + (
        draw.choice(["\n", "\n", "\r\n"]),)
    unit, per_m = draw.choice([("mm", 1e3), ("um", 1e6), ("m", 1)])
    names = draw.choice([("time_s", f"displacement_{unit}"), ("Time (s)", f"Laser ({unit})"), ("t [s]", f"x [{unit}]"),
                         ("Time / s", f"Distance / {unit}")])
    if style in ("clock", "date"):
        names = ("Time", names[1])
    if style == "ms":
        names = (re.sub(r"s(?=[)\]]?$)", "ms", names[0]), names[1])
    above = draw.choice([[], [], ["# made by a logger"], ["Logger 7", f"Sample rate{separator}{rate:.6g} Hz", ""]])
    missing = set(draw.sample(range(rows), draw.choice([0, 0, 0, 1, 5])))
    doubled = set(draw.sample(range(rows), draw.choice([0] * 5 + [2])))
    bad = draw.choice([""] * 7 + ["nan", "-", "1e400"])
    jitter = draw.choice([0, 0, 0, 0.003, 0.05])
    lines = above + [separator.join(names)]
    for row in range(rows):
        t = max(row + draw.gauss(0, jitter), 0) / rate
        cell = bad if bad and row % 97 == 50 else f"{per_m * (1e-3 + 1e-4 * math.sin(row / 3.7)):.7g}"
        text = separator.join([time(t), cell])
        lines += [text.replace(".", ",") if comma else text] * (0 if row in missing else 2 if row in doubled else 1)
    return end.join(lines) + end


def scenes(name, count):
    """Scenes of accuracies.py, whose seeds go through all effects and drives; files of drives stand beside them."""
    os.mkdir(name)
    os.mkdir(f"{name}_drives")
    for n in range(count):
        _, _, table, volts = accuracies.scene_of(n)
        if volts:
            table["drive"]["file"] = f"../{name}_drives/{n:02}.csv"
            rows = "".join(f"{volt!r}\n" for volt in volts)
            pathlib.Path(f"{name}_drives", f"{n:02}.csv").write_text("voltage_v\n" + rows)
        pathlib.Path(name, f"{n:02}.toml").write_text(accuracies.toml_of(table))
