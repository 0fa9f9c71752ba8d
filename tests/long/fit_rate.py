#!/usr/bin/python3
"""fit-lra of two records of 10 000 samples, the whole process, beside SciPy's curve_fit in the same run.

  fit_rate.py build/release/bin [--samples 10000] [--rounds 15]

An open drop and one with 33 ohm, white noise of 0.5 % (seeded), as CSV files that have just been written, so
that they are in the page cache. All sides fit one closed form, the coil's inductance included, with the same
parameters: Kv, Bv, Km^2, and each record's amplitude, impact and offset. SciPy is given the records as
arrays, cut where fit-lra cuts them, weights, and start values as good as a matrix pencil's; it runs with its
own settings, differences for derivatives, and once more with tolerances of 1e-15. `the fit alone` is ours of
the same arrays, weights and start, to rounding and with its covariance (bench/fit_rate.cc). The Python process
imports, reads both files and fits with curve_fit's own settings. Rounds in alternation.
"""
import argparse
import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

os.environ["OMP_NUM_THREADS"] = "1"   # on both sides one thread; read when NumPy is loaded
try:
    import numpy as np
    from scipy.optimize import curve_fit
except ImportError:
    print("needs SciPy (python3-scipy)")
    raise SystemExit(77)

MV_KG, R_OHM, L_H, LOADS_OHM = 1.4e-3, 27.0, 130e-6, (np.inf, 33.0)
LENGTH_S, QUIET_S, IMPACT_S, OFFSET_V, NOISE = 0.3, 0.02, 1.7e-5, 0.01, 0.005
AMPLITUDE_V = np.sqrt(2 * 9.80665 * 0.01)
TRUTH = {"Kv": 2800.0, "Bv": 0.0322, "Km": 1.0}


def voltage(t, stiffness, damping, km_squared, load_ohm, speed_v):
    """Terminal voltage `t` seconds after the blow; sim/ring_down.h has the equations."""
    g = 0.0 if np.isinf(load_ohm) else 1 / (R_OHM + load_ohm)
    divider = 1.0 if np.isinf(load_ohm) else load_ohm * g
    tau, w2, b = L_H * g, stiffness / MV_KG, damping / MV_KG
    electric = g * km_squared / MV_KG
    y = 1.0
    for _ in range(8):
        square = y * y - b * tau * y + tau * tau * w2
        value = (1 - y) * square - tau * electric * y
        y -= value / ((1 - y) * (2 * y - b * tau) - square - tau * electric)
    square = y * y - b * tau * y + tau * tau * w2
    decay, q = 0.5 * (b + electric * y / square), w2 / y
    n = y * y - 2 * decay * tau * y + tau * tau * q
    angular = np.sqrt(q - decay * decay)
    shape = np.exp(-decay * t) * (np.cos(angular * t) + (tau * q / y - decay) / angular * np.sin(angular * t))
    if tau > 0:
        shape -= np.exp(-y / tau * t)
    return -speed_v * divider * y / n * shape


def write_records(folder, samples):
    """The files, and each record's times and voltages as they stand in them."""
    noise = np.random.default_rng(1)
    step_s = LENGTH_S / samples
    paths, records = [], []
    for load_ohm in LOADS_OHM:
        times_s = step_s * np.arange(samples) - round(QUIET_S / step_s) * step_s
        volts = OFFSET_V + NOISE * AMPLITUDE_V * noise.standard_normal(samples)
        behind = times_s > IMPACT_S
        volts[behind] += voltage(times_s[behind] - IMPACT_S, TRUTH["Kv"], TRUTH["Bv"], TRUTH["Km"] ** 2, load_ohm,
                                 AMPLITUDE_V)
        header = {"case": "held", "load_ohm": load_ohm, "moving_mass_kg": MV_KG, "resistance_ohm": R_OHM,
                  "inductance_h": L_H}
        lines = [f"# {key} = {value}" for key, value in header.items()] + ["time_s,voltage_v"]
        lines += [f"{t:.6e},{v:.6f}" for t, v in zip(times_s, volts)]
        path = pathlib.Path(folder) / f"{'open' if np.isinf(load_ohm) else 'loaded'}.csv"
        path.write_text("\n".join(lines) + "\n")
        paths.append(path)
        records.append((times_s, np.array([float(line.split(",")[1]) for line in lines[len(header) + 1:]])))
    return paths, records


class JointFit:
    """The two records as one curve over the nine parameters."""

    def __init__(self, records, parts):
        """`parts`: of each record the number of its last samples and their noise."""
        self.times = [times[-samples:] for (times, _), (samples, _) in zip(records, parts)]
        self.values = np.concatenate([volts[-samples:] for (_, volts), (samples, _) in zip(records, parts)])
        self.sigma = np.concatenate([np.full(samples, noise_v) for samples, noise_v in parts])
        self.start = [TRUTH["Kv"] * 1.0002, TRUTH["Bv"] * 1.02, 0.97,
                      AMPLITUDE_V * 1.01, IMPACT_S + 1e-6, 0.0, AMPLITUDE_V * 0.99, IMPACT_S - 1e-6, 0.0]

    def model(self, _, *p):
        return np.concatenate([p[5 + 3 * r] + voltage(self.times[r] - p[4 + 3 * r], *p[:3], load_ohm, p[3 + 3 * r])
                               for r, load_ohm in enumerate(LOADS_OHM)])

    def run(self, **tolerances):
        p, covariance = curve_fit(self.model, None, self.values, p0=self.start, sigma=self.sigma, **tolerances)
        self.deviations = np.sqrt(np.diag(covariance))[:3]
        return {"Kv": p[0], "Bv": p[1], "Km": np.sqrt(p[2])}

    def task(self):
        """The same arrays, weights and start for bench/fit_rate.cc, every number with all of its digits."""
        numbers = [*self.start[:3], MV_KG, R_OHM, L_H, len(self.times)]
        first = 0
        for r, times in enumerate(self.times):
            values = self.values[first:first + len(times)]
            numbers += [len(times), LOADS_OHM[r], self.sigma[first], *self.start[3 + 3 * r:6 + 3 * r]]
            numbers += np.column_stack((times, values)).ravel().tolist()
            first += len(times)
        return " ".join(repr(float(number)) for number in numbers)


class OurFit:
    """bench/fit_rate.cc with the task in its memory."""

    def __init__(self, program, task):
        self.process = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                        bufsize=1)
        self.process.stdin.write(task + "\n")

    def run(self):
        self.process.stdin.write("fit\n")
        self.process.stdin.flush()
        self.seconds, stiffness, damping, square, *self.deviations = map(float, self.process.stdout.readline().split())
        return {"Kv": stiffness, "Bv": damping, "Km": np.sqrt(square)}


def processor_seconds():
    """Of this process and those it has waited for."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in used)


def timed(call):
    """Milliseconds by the clock and by the processor, and the result."""
    start, processor = time.perf_counter(), processor_seconds()
    result = call()
    return 1e3 * (time.perf_counter() - start), 1e3 * (processor_seconds() - processor), result


def constants(answer):
    return {constant: answer["parameters"][constant]["value"] for constant in TRUTH}


def compare(program, paths, records, rounds):
    command = [program, *paths, "--json"]
    run = lambda: json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    answer = run()
    fit = JointFit(records, [(r["samples"], r["residual_rms_v"]) for r in answer["records"]])
    tight = dict(ftol=1e-15, xtol=1e-15, gtol=1e-15, maxfev=10_000)
    ours = OurFit(pathlib.Path(program).parent / "fit_rate", fit.task())
    whole = [sys.executable, os.path.abspath(__file__), "--peer", *map(str, paths), json.dumps(
        [[r["samples"], r["residual_rms_v"]] for r in answer["records"]])]
    sides = {
        "fit-lra, whole process": lambda: constants(run()),
        "the fit alone": ours.run,
        "curve_fit alone": fit.run,
        "curve_fit alone, to rounding": lambda: fit.run(**tight),
        "Python that imports, reads, fits": lambda: json.loads(
            subprocess.run(whole, check=True, capture_output=True).stdout),
    }
    times = {name: [] for name in sides}
    for name in list(sides) * rounds:
        clock_ms, processor_ms, found = timed(sides[name])
        if name == "the fit alone":
            clock_ms = processor_ms = 1e3 * ours.seconds
        times[name].append((clock_ms, processor_ms))
        for constant, value in (found or {}).items():
            off = value / constants(answer)[constant] - 1
            if abs(off) > 1e-5:
                raise SystemExit(f"{name}: {constant} is {off:.1e} off fit-lra's")
    tight_found = fit.run(**tight)
    ours.run()
    for mine, theirs in zip(ours.deviations, fit.deviations):
        if abs(mine / theirs - 1) > 1e-3:
            raise SystemExit(f"a standard deviation is {mine:.6g} here and {theirs:.6g} by curve_fit")
    return times, {c: abs(tight_found[c] / constants(answer)[c] - 1) for c in TRUTH}


def report(times, off):
    best = {name: min(clock for clock, _ in all_) for name, all_ in times.items()}
    for name, all_ in times.items():
        clock, processor = np.median(all_, axis=0)
        print(f"{name:36} best {best[name]:7.2f} ms, median {clock:7.2f} ms; of the processor {processor:7.2f} ms")
    print(f"fit against fit: curve_fit takes {best['curve_fit alone'] / best['the fit alone']:.1f} times as long with its "
          f"own settings, {best['curve_fit alone, to rounding'] / best['the fit alone']:.1f} times to rounding, as ours")
    whole, python = best["fit-lra, whole process"], best["Python that imports, reads, fits"]
    print(f"process against process: Python takes {python / whole:.1f} times as long as fit-lra")
    print("constants agree to " + ", ".join(f"{constant} {value:.1e}" for constant, value in off.items()))


def peer(open_path, loaded_path, parts):
    """What a Python program does that is told where each record's ring-down begins, and its noise."""
    records = [np.loadtxt(path, delimiter=",", skiprows=6, unpack=True) for path in (open_path, loaded_path)]
    print(json.dumps(JointFit(records, json.loads(parts)).run()))


def main():
    if sys.argv[1:2] == ["--peer"]:
        peer(*sys.argv[2:])
        return
    parser = argparse.ArgumentParser()
    parser.add_argument("programs")
    parser.add_argument("--samples", type=int, default=10_000)
    parser.add_argument("--rounds", type=int, default=15)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        paths, records = write_records(folder, arguments.samples)
        program = pathlib.Path(arguments.programs) / "fit-lra"
        report(*compare(program, paths, records, arguments.rounds))


main()
