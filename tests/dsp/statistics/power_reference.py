#!/usr/bin/env python3
"""Writes tests/dsp/statistics/power_reference.csv: which paired difference, in its standard deviations, n subjects
show with 80 % power at 5 %, two-sided, corrected for m tests (5 % / m).

    power_reference.py             writes it (SciPy)
    power_reference.py --check     computes it anew and compares; 77 without SciPy

Shares nothing with dsp/: the normal tails are averaged over the chi distribution by quadrature, because SciPy's
noncentral t (nct) is Boost's, as dsp's is. The two are held against each other where nct has a number.
"""
import math
import pathlib
import sys

try:
    from scipy import integrate, optimize, special, stats
except ImportError as missing:
    print(f"needs python3-scipy: {missing}")
    sys.exit(77)

TARGET = pathlib.Path(__file__).with_name("power_reference.csv")
SUBJECTS = (2, 3, 4, 5, 6, 8, 10, 12, 16, 24, 40, 100)
TESTS = (1, 2, 3, 6, 10)
POWER, ALPHA = 0.8, 0.05


def effect(n, m):
    df = n - 1
    critical = stats.t.isf(ALPHA / m / 2, df)

    def power(delta):
        def tails(s):
            return stats.chi.pdf(s * math.sqrt(df), df) * math.sqrt(df) * (
                special.ndtr(delta - critical * s) + special.ndtr(-delta - critical * s))
        # the chi distribution of s has its mass below 1 + 40 / sqrt(df), the step of the tails is at delta / critical
        ends = [0, delta / critical, 1, 1 + 10 / math.sqrt(df), 1 + 40 / math.sqrt(df)]
        return sum(integrate.quad(tails, a, b, epsabs=1e-13, epsrel=1e-12, limit=400)[0]
                   for a, b in zip(sorted(ends), sorted(ends)[1:]))

    delta = optimize.brentq(lambda d: power(d) - POWER, 0.1, 3 + 2 * critical, xtol=1e-12)
    peer = stats.nct.sf(critical, df, delta) + stats.nct.cdf(-critical, df, delta)
    assert math.isnan(peer) or abs(peer - POWER) < 1e-9, (n, m, peer)
    return delta / math.sqrt(n)


def main():
    rows = [(n, m, effect(n, m)) for n in SUBJECTS for m in TESTS]
    if "--check" in sys.argv[1:]:
        kept = [line.split(",") for line in TARGET.read_text().splitlines()[2:]]
        worst = max(abs(ours / float(line[2]) - 1) for (_, _, ours), line in zip(rows, kept, strict=True))
        print(f"worst relative difference {worst:.2g}")
        return 0 if worst < 1e-9 else 1
    TARGET.write_text("# Made by tests/dsp/statistics/power_reference.py with SciPy; that script says what it is\n"
                      "subjects,tests,d_z\n" + "".join(f"{n},{m},{d:.12g}\n" for n, m, d in rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
