#!/usr/bin/python3
"""fit-lra on records that hold no ring-down, on true ring-downs, and on ring-downs with dry friction and a long contact.

  fit_evidence.py build/release/bin [--records 400] [--seeds 200] [--seed 1] [--only none|true|friction] [--keep DIR]

Written without the program's code: every record is summed up or solved here. Bars: of what is no ring-down, status 3
and nothing determined in all, with a reason; of the true ones at most 1 % refused; of those with dry friction of 0.2-3 %
of the spring force at the first peak and a contact of 0.2-1 ms, intervals that hold the truth in 90 % or more of those
answered, and at most 20 % refused.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np


def write(path, t, v, header=""):
    with open(path, "w") as file:
        file.write(header + "time_s,voltage_v\n")
        file.writelines(f"{a:.9e},{b:.7e}\n" for a, b in zip(t, v))


def ask(program, path, *words):
    run = subprocess.run([program, str(path), "--json", *words], capture_output=True, text=True)
    document = json.loads(run.stdout) if run.stdout.strip() else None
    return run.returncode, document, run.stderr.strip()


def pick(rng, *choices):
    return choices[rng.integers(len(choices))]


def log_uniform(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


# ---------------------------------------------------------------- what is no ring-down

def square_through_rc(rng):
    n = int(rng.integers(2000, 9000))
    cycles = rng.uniform(1.5, 20)
    tau = rng.uniform(0.01, 0.3)                     # of a period
    x = np.linspace(0, cycles, n) + rng.uniform()
    fine = np.where(np.floor(2 * x) % 2 == 0, 1.0, -1.0)
    a = np.exp(-(x[1] - x[0]) / tau)
    v = np.empty(n)
    level = rng.uniform(-1, 1)
    for k in range(n):
        level = a * level + (1 - a) * fine[k]
        v[k] = level
    return v, log_uniform(rng, 1e-3, 0.02)


def chirp(rng):
    n = int(rng.integers(2000, 9000))
    x = np.arange(n) / n
    f0 = log_uniform(rng, 8, n / 60)
    rise = pick(rng, rng.uniform(0.3, 2.5), -rng.uniform(0.3, 0.7))
    decay = pick(rng, 0.0, rng.uniform(1, 4), rng.uniform(4, 9))
    reach = 1.0 if decay == 0 else min(1.0, 2 / decay)   # the frequency has changed by `rise` there
    begin = pick(rng, 0.0, rng.uniform(0.02, 0.3))
    y = np.clip(x - begin, 0, None)
    phase = 2 * np.pi * (f0 * y + 0.5 * f0 * rise * np.minimum(y, reach) ** 2 / reach
                         + f0 * rise * np.clip(y - reach, 0, None))
    v = np.where(x >= begin, np.exp(-decay * y) * np.sin(phase + rng.uniform(0, 6.28) * (begin == 0)), 0)
    return v, log_uniform(rng, 1e-3, 0.03)


def two_modes(rng):
    n = int(rng.integers(2000, 9000))
    x = np.arange(n) / n
    f1 = log_uniform(rng, 10, n / 60)
    f2 = f1 * pick(rng, rng.uniform(1.15, 1.6), rng.uniform(1.6, 3.2))
    begin = pick(rng, 0.0, rng.uniform(0.02, 0.3))
    y = np.clip(x - begin, 0, None)
    d1, d2 = rng.uniform(2, 8, 2)
    v = np.exp(-d1 * y) * np.cos(2 * np.pi * f1 * y + rng.uniform(0, 6.28))
    v += rng.uniform(0.35, 1) * np.exp(-d2 * y) * np.cos(2 * np.pi * f2 * y + rng.uniform(0, 6.28))
    return np.where(x >= begin, v, 0), log_uniform(rng, 1e-3, 0.03)


def noise(rng):
    n = int(rng.integers(1000, 9000))
    kind = rng.integers(4)
    white = rng.standard_normal(n)
    if kind == 0:
        return white, 0.0
    if kind == 1:
        return np.cumsum(white) / np.sqrt(n), 0.001
    f = np.fft.rfftfreq(n)
    f[0] = f[1]
    if kind == 2:
        return np.fft.irfft(np.fft.rfft(white) / np.sqrt(f), n) * np.sqrt(1 / n) * 3, 0.001
    centre, width = log_uniform(rng, 0.003, 0.1), rng.uniform(0.02, 0.3)
    shape = 1 / (1 + ((f - centre) / (width * centre)) ** 2)
    v = np.fft.irfft(np.fft.rfft(white) * shape, n)
    return v / v.std(), 0.01


def step(rng):
    n = int(rng.integers(1000, 9000))
    x = np.arange(n) / n
    v = np.zeros(n)
    for _ in range(int(rng.integers(1, 4))):
        at, tau = rng.uniform(0.05, 0.9), pick(rng, 1e-6, rng.uniform(0.001, 0.1))
        v += rng.normal() * np.where(x > at, 1 - np.exp(-(x - at).clip(0) / tau), 0)
    return v / max(np.abs(v).max(), 1e-3), log_uniform(rng, 1e-3, 0.05)


def aperiodic(rng):
    n = int(rng.integers(1000, 9000))
    x = np.arange(n) / n
    begin = pick(rng, 0.0, rng.uniform(0.02, 0.3))
    y = np.clip(x - begin, 0, None)
    a = rng.uniform(4, 20)
    kind = rng.integers(3)
    if kind == 0:
        v = np.exp(-a * y)
    elif kind == 1:
        v = np.exp(-a * y) + rng.uniform(0.2, 1) * np.exp(-a * rng.uniform(2, 6) * y)
    else:
        v = (1 + a * y) * np.exp(-a * y)
    return np.where(x >= begin, v, 0), log_uniform(rng, 1e-3, 0.03)


def beat(rng):
    n = int(rng.integers(2000, 9000))
    x = np.arange(n) / n
    beats = rng.uniform(1.2, 8)
    f1 = log_uniform(rng, 8 * beats, max(n / 40, 9 * beats))
    v = np.cos(2 * np.pi * f1 * x + rng.uniform(0, 6.28))
    v += rng.uniform(0.6, 1) * np.cos(2 * np.pi * (f1 + beats) * x + rng.uniform(0, 6.28))
    return v, log_uniform(rng, 1e-3, 0.03)


def hum(rng):
    n = int(rng.integers(2000, 9000))
    x = np.arange(n) / n
    f1 = log_uniform(rng, 4, n / 40)
    phase = 2 * np.pi * f1 * x + rng.uniform(0, 6.28)
    v = np.cos(phase)
    for harmonic in (2, 3, 5):
        v += pick(rng, 0.0, rng.uniform(0, 0.15)) * np.cos(harmonic * phase + rng.uniform(0, 6.28))
    return v, log_uniform(rng, 1e-3, 0.05)


NONE = (square_through_rc, chirp, two_modes, noise, step, aperiodic, beat, hum)


def scaled(rng, v, noise_share):
    """On a time base, with an offset and noise, in volts."""
    n = len(v)
    span = log_uniform(rng, 1e-3, 3)
    t = np.arange(n) * (span / n)
    volts = log_uniform(rng, 3e-3, 3)
    v = volts * (v + noise_share * rng.standard_normal(n) + pick(rng, 0.0, rng.normal()))
    if rng.random() < 0.5:
        code = (v.max() - v.min()) / 2 ** rng.integers(8, 15)
        v = np.round(v / code) * code
    return t, v


# ---------------------------------------------------------------- true ring-downs

def true_ring_down(rng):
    f0 = log_uniform(rng, 5, 1e5)
    quality = log_uniform(rng, 3, 3000)
    d = np.pi * f0 / quality
    decays = rng.uniform(1.5, 8)
    per_period = log_uniform(rng, 10, 60)
    length = decays / d
    if length * f0 > 3000:
        length = 3000 / f0
    length = max(length, 4 / f0)
    step_s = 1 / (f0 * per_period)
    before = pick(rng, 0.0, rng.uniform(0.05, 0.4)) * length
    t = np.arange(int((before + length) / step_s)) * step_s - before
    w = np.sqrt((2 * np.pi * f0) ** 2 - d * d)
    at = t - rng.uniform(0, step_s)
    if before == 0:
        v = np.exp(-d * t) * np.cos(w * t + rng.uniform(0, 2 * np.pi))
    else:
        v = np.where(at >= 0, np.exp(-d * at.clip(0)) * (np.cos(w * at) - d / w * np.sin(w * at)), 0)
    noise_share = log_uniform(rng, 1e-4, 0.1)
    v = v + noise_share * rng.standard_normal(len(t)) + pick(rng, 0.0, rng.normal())
    v += pick(rng, 0.0, rng.uniform(-0.05, 0.05)) * np.linspace(0, 1, len(t))
    if rng.random() < 0.5:
        code = (v.max() - v.min()) * 1.2 / 2 ** rng.integers(8, 17)
        v = np.round(v / code) * code
    return t, v * log_uniform(rng, 1e-3, 10), f0, quality


# ---------------------------------------------------------------- dry friction and a long contact

MV_KG, KV, BV, KM = 1.4e-3, 2800.0, 0.0322, 1.0


def friction_drop(rng):
    """The mover under a half sine of the case's acceleration for `contact`, then free; half swing by half swing.

    x'' + 2 d x' + w^2 x + w^2 xf sign(x') = -a(t): between two turns linear, so each is the exact solution about
    -xf sign(x'), found turn by turn; during the contact by the classical Runge-Kutta method in 4000 steps.
    """
    share, contact = log_uniform(rng, 2e-3, 3e-2), rng.uniform(0.2e-3, 1e-3)
    height = rng.uniform(5e-3, 20e-3)
    speed = np.sqrt(2 * 9.80665 * height)
    w2, two_d = KV / MV_KG, BV / MV_KG
    w = np.sqrt(w2)
    xf = share * speed / w

    def slope(t, x, v):
        a = speed * np.pi / (2 * contact) * np.sin(np.pi * t / contact)
        return -two_d * v - w2 * (x + xf * np.sign(v)) + a

    x = v = 0.0
    steps = 4000
    h = contact / steps
    inside_t, inside_v = [0.0], [0.0]
    for k in range(steps):
        t = k * h
        k1 = slope(t, x, v)
        k2 = slope(t + h / 2, x + h / 2 * v, v + h / 2 * k1)
        k3 = slope(t + h / 2, x + h / 2 * v + h * h / 4 * k1, v + h / 2 * k2)
        k4 = slope(t + h, x + h * v + h * h / 2 * k2, v + h * k3)
        x += h * v + h * h / 6 * (k1 + k2 + k3)
        v += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        inside_t.append((k + 1) * h)
        inside_v.append(v)

    step_s = pick(rng, 2e-5, 5e-5, 1e-4)
    t = np.arange(-round(0.01 / step_s), round(0.3 / step_s)) * step_s
    at = t - rng.uniform(0, step_s)
    velocity = np.zeros(len(t))
    in_contact = (at >= 0) & (at < contact)
    velocity[in_contact] = np.interp(at[in_contact], inside_t, inside_v)
    d = two_d / 2
    wd = np.sqrt(w2 - d * d)
    begin = contact
    while begin < at[-1]:
        s = np.sign(v) if v != 0 else -np.sign(x)
        if v == 0 and abs(x) <= xf:
            break
        u = x + s * xf
        # v(t) = e^(-d t) (v cos - (d v + w2 u)/wd sin): the next zero behind 0
        b = -(d * v + w2 * u) / wd
        turn = np.arctan2(-v, b) / wd
        while turn <= 1e-12:
            turn += np.pi / wd
        here = (at >= begin) & (at < begin + turn)
        since = at[here] - begin
        velocity[here] = np.exp(-d * since) * (v * np.cos(wd * since) + b * np.sin(wd * since))
        x = np.exp(-d * turn) * (u * np.cos(wd * turn) + (v + d * u) / wd * np.sin(wd * turn)) - s * xf
        v = 0.0
        begin += turn
    noise_share = log_uniform(rng, 1e-3, 1e-2)
    volts = -KM * velocity + noise_share * KM * speed * rng.standard_normal(len(t)) + rng.normal(0, 0.01)
    return t, volts, height, share, contact


def inside(value, truth):
    if value["determined"]:
        return value["lower_95"] <= truth <= value["upper_95"]
    return None


# ---------------------------------------------------------------- the three runs

def run_none(program, folder, count, seed, verbose):
    wrong = 0
    for k in range(count):
        rng = np.random.default_rng([seed, 1, k])
        make = NONE[k % len(NONE)]
        t, v = scaled(rng, *make(rng))
        path = folder / f"none_{k}_{make.__name__}.csv"
        write(path, t, v)
        status, document, said = ask(program, path)
        fine = status == 3 and said and (document is None or not (
            document["parameters"]["Kv"]["determined"] or document["derived"]["natural_frequency"]["determined"]
            or document["derived"]["quality_factor"]["determined"]))
        wrong += not fine
        if not fine or verbose:
            found = document and document["natural_frequency_hz"]
            print(f"{'ok ' if fine else 'BAD'} {path.name}: status {status}, f0 {found}; {said[:160]}")
    print(f"no ring-down: {count - wrong} of {count} refused by name")
    return wrong == 0


def run_true(program, folder, count, seed, verbose):
    refused = outside = 0
    for k in range(count):
        rng = np.random.default_rng([seed, 2, k])
        t, v, f0, quality = true_ring_down(rng)
        path = folder / f"true_{k}.csv"
        write(path, t, v)
        status, document, said = ask(program, path)
        if status != 0:
            refused += 1
            print(f"refused {path.name}: f0 {f0:.5g} Q {quality:.4g} rows {len(t)}: {said[:200]}")
            continue
        f, q = (document["derived"][key] for key in ("natural_frequency", "quality_factor"))
        miss = not (inside(f, f0) and inside(q, quality))
        outside += miss
        if verbose and miss:
            print(f"outside {path.name}: f0 {f0:.7g} {f['value']:.7g} {f['lower_95']:.7g} {f['upper_95']:.7g}, Q {quality:.5g} {q['lower_95']:.5g} {q['upper_95']:.5g}")
    print(f"true ring-downs: {refused} of {count} refused ({100 * refused / count:.2g} %), f0 or Q outside its interval in {outside}")
    return refused <= 0.01 * count


def run_friction(program, folder, count, seed, verbose):
    refused = answered = 0
    holds = {"Kv": 0, "Bv": 0, "Km": 0}
    for k in range(count):
        rng = np.random.default_rng([seed, 3, k])
        t, v, height, share, contact = friction_drop(rng)
        path = folder / f"friction_{k}.csv"
        write(path, t, v)
        status, document, said = ask(program, path, "--moving-mass", "1.4g", "--held", "--drop-height", f"{height * 1e3:.6f}mm",
                                     "--rebound", "0", "--resistance", "27ohm")
        if status != 0 or not all(document["parameters"][c]["determined"] for c in holds):
            refused += 1
            if verbose:
                print(f"refused {path.name}: friction {share:.4f}, contact {1e3 * contact:.2f} ms: {said[:200]}")
            continue
        answered += 1
        for constant, truth in (("Kv", KV), ("Bv", BV), ("Km", KM)):
            value = document["parameters"][constant]
            good = inside(value, truth)
            holds[constant] += good
            if verbose and not good:
                print(f"outside {path.name}: {constant} {value['value']:.6g} {value['lower_95']:.6g} {value['upper_95']:.6g}, "
                      f"friction {share:.4f}, contact {1e3 * contact:.2f} ms")
    shares = ", ".join(f"{c} {100 * n / max(answered, 1):.3g} %" for c, n in holds.items())
    print(f"friction and contact: {refused} of {count} refused, intervals hold in {shares}")
    return refused <= 0.2 * count and all(n >= 0.9 * answered for n in holds.values())


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("programs")
    parser.add_argument("--records", type=int, default=400)
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=("none", "true", "friction"))
    parser.add_argument("--keep")
    parser.add_argument("--verbose", action="store_true")
    arguments = parser.parse_args()
    program = pathlib.Path(arguments.programs) / "fit-lra"
    runs = {"none": (run_none, arguments.records), "true": (run_true, arguments.records),
            "friction": (run_friction, arguments.seeds)}
    good = True
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(arguments.keep or temporary)
        folder.mkdir(exist_ok=True)
        for name, (run, count) in runs.items():
            if arguments.only in (None, name):
                good = run(program, folder, count, arguments.seed, arguments.verbose) and good
    return 0 if good else 1


sys.exit(main())
