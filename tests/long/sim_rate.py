#!/usr/bin/python3
"""The thesis's adapter scene, 0.1 s from rest and 1000 outputs of all seven states, beside its peers in the same run.

  chrt -f 5 /usr/bin/python3 tests/long/sim_rate.py build/release/bin [--rounds 9]

Exact stepping with its set-up; SUNDIALS CVODE at rtol 1e-6 called directly (dense Jacobian, an absolute tolerance for
each state, BDF and Adams) and Boost.odeint's Dormand-Prince (bench/sim_rate.cc, sim_cost_peers.h); csim of Scilab 6.1
with the voltage as a function, the thesis's tool, where scilab-cli is installed; SciPy's solve_ivp at rtol 1e-6 with
the same tolerances and Jacobian, and its lsim. Rounds in alternation, medians. Errors: the largest at any output over
the state's largest value, against 50 digits (tests/sim/reference/linear_reference.py). The bars: CVODE, the quicker of
its two methods, takes 50 times as long, csim 1000 times, and both are at least 1000 times as wrong. Exit status 1 where
a bar is missed; with one round times are not judged.
"""
import argparse
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

os.environ["OMP_NUM_THREADS"] = "1"   # read when NumPy is loaded
try:
    import mpmath as mp
    import numpy as np
    from scipy import signal
    from scipy.integrate import solve_ivp
except ImportError as missing:
    print(f"needs {missing.name} (python3-numpy, python3-scipy, python3-mpmath)")
    raise SystemExit(77)

ROOT = pathlib.Path(__file__).resolve().parents[2]
STATES = ["xv", "vv", "xa", "va", "xs", "vs", "i"]
OUTPUTS, RATE_HZ, RTOL = 1000, 1e4, 1e-6
TIMES = np.arange(OUTPUTS + 1) / RATE_HZ
VOLT, OMEGA = 5, 2 * np.pi * 225


def linear_reference():
    spec = importlib.util.spec_from_file_location("linear_reference", ROOT / "tests/sim/reference/linear_reference.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def truth(reference):
    """(outputs, 7), to 50 digits before they are rounded."""
    response = reference.FromRest(reference.SCENES["Adapter"])
    rows = []
    for output in range(OUTPUTS + 1):
        lines = [mp.exp(rate * output / mp.mpf(RATE_HZ)) for rate in response.rates]
        rows.append([float(mp.re(mp.fdot(weights, lines))) for weights in response.weights])
    return np.array(rows)


class Program:
    """bench/sim_rate.cc."""

    def __init__(self, path, folder):
        self.process = subprocess.Popen([path], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1)
        self.folder = folder

    def run(self, method, repeats):
        path = os.path.join(self.folder, method)
        self.process.stdin.write(f"{method} {RTOL} {repeats} {path}\n")
        seconds = float(self.process.stdout.readline())
        return seconds, np.fromfile(path).reshape(-1, 7)


class Scilab:
    """csim, five times in a Scilab of its own; functions and constants are those of csim_reference.sce."""

    def __init__(self, folder):
        script = (ROOT / "tests/sim/reference/csim_reference.sce").read_text()
        self.path = os.path.join(folder, "csim")
        self.script = self.path + ".sce"
        pathlib.Path(self.script).write_text(
            script[script.index("mode(-1)"):script.index("// every so many columns")] + f"""
sl = adapter(600, 0.75); t = (0:{OUTPUTS})/{RATE_HZ}; x0 = zeros(7, 1);
for k = 1:5
  tic(); [y, x] = csim(volt, t, sl, x0); mprintf("took %.9f\\n", toc());
end
f = mopen("{self.path}", "wb"); mput(x, "d", f); mclose(f);
exit
""")

    def run(self):
        words = subprocess.run(["scilab-cli", "-nb", "-f", self.script], check=True, capture_output=True, text=True,
                               stdin=subprocess.DEVNULL).stdout.split()
        seconds = [float(number) for word, number in zip(words, words[1:]) if word == "took"]
        return float(np.median(seconds)), np.fromfile(self.path).reshape(-1, 7)


class SciPy:
    def __init__(self, reference, largest):
        a, b = reference.system(reference.SCENES["Adapter"])
        self.a = np.array(a.tolist(), dtype=float)
        self.b = np.array(b.tolist(), dtype=float).ravel()
        self.tolerances = dict(rtol=RTOL, atol=0.1 * RTOL * largest)
        self.system = signal.StateSpace(self.a, self.b[:, None], np.eye(7), np.zeros((7, 1)))

    def rate(self, t, x):
        return self.a @ x + self.b * (VOLT * np.sin(OMEGA * t))

    def solve(self, method):
        jacobian = {} if method in ("DOP853", "RK45") else {"jac": lambda t, x: self.a}
        start = time.perf_counter()
        solution = solve_ivp(self.rate, (0, TIMES[-1]), np.zeros(7), method, t_eval=TIMES, **self.tolerances, **jacobian)
        return time.perf_counter() - start, solution.y.T

    def lsim(self):
        start = time.perf_counter()
        _, _, x = signal.lsim(self.system, VOLT * np.sin(OMEGA * TIMES), TIMES)
        return time.perf_counter() - start, x


def peers(programs, folder, reference, largest):
    program = Program(os.path.join(programs, "sim_rate"), folder)
    scipy = SciPy(reference, largest)
    sides = {
        "exact steps": lambda: program.run("exact", 101),
        "CVODE BDF 1e-6": lambda: program.run("bdf", 5),
        "CVODE Adams 1e-6": lambda: program.run("adams", 3),
        "odeint dopri5 1e-6": lambda: program.run("dopri5", 5),
        "SciPy lsim (lines between samples)": scipy.lsim,
    }
    for method in ("LSODA", "BDF", "Radau", "DOP853"):
        sides[f"SciPy {method} 1e-6"] = lambda method=method: scipy.solve(method)
    if shutil.which("scilab-cli"):
        sides["Scilab csim"] = Scilab(folder).run
    return sides


def measure(sides, exact, rounds):
    times, errors = {name: [] for name in sides}, {}
    largest = np.abs(exact).max(axis=0)
    for name in list(sides) * rounds:
        seconds, states = sides[name]()
        times[name].append(seconds)
        errors[name] = np.abs(states - exact).max(axis=0) / largest
    return {name: float(np.median(all_)) for name, all_ in times.items()}, errors


def judge(name, bar, medians, errors, rounds):
    """Whether a peer is as far behind as it should be: its best state beside the worst of ours."""
    slower = medians[name] / medians["exact steps"]
    wronger = errors[name].min() / errors["exact steps"].max()
    print(f"{name} takes {slower:.0f} times as long (bar {bar}); its best state is {wronger:.1e} times as wrong as the "
          f"worst of ours (bar 1000)")
    return wronger >= 1000 and (rounds == 1 or slower >= bar)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("programs")
    parser.add_argument("--rounds", type=int, default=9)
    arguments = parser.parse_args()
    reference = linear_reference()
    exact = truth(reference)
    with tempfile.TemporaryDirectory() as folder:
        sides = peers(arguments.programs, folder, reference, np.abs(exact).max(axis=0))
        medians, errors = measure(sides, exact, arguments.rounds)
    print(f"{'':34}  {'time':>11}  x ours  error: " + "  ".join(f"{state:7}" for state in STATES))
    for name, seconds in medians.items():
        print(f"{name:34}  {1e6 * seconds:8.1f} us  {seconds / medians['exact steps']:6.0f}         "
              + "  ".join(f"{error:7.1e}" for error in errors[name]))
    good = errors["exact steps"].max() < 1e-12
    best = min(("CVODE BDF 1e-6", "CVODE Adams 1e-6"), key=medians.get)
    good &= judge(best, 50, medians, errors, arguments.rounds)
    if "Scilab csim" in sides:
        good &= judge("Scilab csim", 1000, medians, errors, arguments.rounds)
    else:
        print("csim was not measured: no scilab-cli here")
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
