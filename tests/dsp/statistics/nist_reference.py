#!/usr/bin/env python3
"""Writes tests/dsp/statistics/nist_reference.h, or checks with --check that it still holds.

Mean, standard deviation and lag-1 autocorrelation of NIST's univariate sets: as certified (of the
decimals), and in exact rational arithmetic of the doubles that stand for them.
"""

import decimal
import pathlib
import sys
from fractions import Fraction

HERE = pathlib.Path(__file__).resolve().parent
VALUES = HERE.parents[2] / "fixtures" / "nist_univariate.txt"
TARGET = HERE / "nist_reference.h"

# https://www.itl.nist.gov/div898/strd/univ/homepage.html
CERTIFIED = {
    "Lew": ("-177.435", "277.332168044316", "-0.307304800605679"),
    "Lottery": ("518.958715596330", "291.699727470969", "-0.120948622967393"),
    "Mavro": ("2.001856", "0.000429123454003053", "0.937989183438248"),
    "Michelso": ("299.8524", "0.0790105478190518", "0.535199668621283"),
    "PiDigits": ("4.5348", "2.86733906028871", "-0.00355099287237972"),
    "NumAcc1": ("10000002", "1", "-0.5"),
    "NumAcc2": ("1.2", "0.1", "-0.999"),
    "NumAcc3": ("1000000.2", "0.1", "-0.999"),
    "NumAcc4": ("10000000.2", "0.1", "-0.999"),
}


def sets():
    values = {name: [] for name in CERTIFIED}
    for line in VALUES.read_text().splitlines():
        if not line.startswith("#"):
            name, *numbers = line.split()
            values[name] += [float(number) for number in numbers]
    values["NumAcc1"] = [10000001.0, 10000003.0, 10000002.0]
    values["NumAcc2"] = [1.2] + [1.1, 1.3] * 500
    values["NumAcc3"] = [1000000.2] + [1000000.1, 1000000.3] * 500
    values["NumAcc4"] = [10000000.2] + [10000000.1, 10000000.3] * 500
    return values


def exact(values):
    decimal.getcontext().prec = 60
    numbers = [Fraction(value) for value in values]
    n = len(numbers)
    mean = sum(numbers) / n
    off = [number - mean for number in numbers]
    squares = sum(d * d for d in off)
    lag = sum(a * b for a, b in zip(off, off[1:])) / squares
    variance = squares / (n - 1)
    deviation = (decimal.Decimal(variance.numerator) / decimal.Decimal(variance.denominator)).sqrt()
    return float(mean), float(deviation), float(lag)


def text():
    lines = ["#pragma once", "", "// Made by tests/dsp/statistics/nist_reference.py; do not edit.", "// clang-format off",
             "#include <array>", "", "namespace haptometer::dsp {", "",
             "/// Mean, standard deviation, lag-1 autocorrelation.", "struct NistSet {",
             "  const char* name;", "  std::array<double, 3> certified;  ///< of the decimals",
             "  std::array<double, 3> exact;      ///< of the stored doubles", "};", "",
             f"inline constexpr std::array<NistSet, {len(CERTIFIED)}> kNistSets{{{{"]
    for name, values in sets().items():
        numbers = ", ".join(repr(number) for number in exact(values))
        lines += [f'    {{"{name}",', f"     {{{', '.join(CERTIFIED[name])}}},", f"     {{{numbers}}}}},"]
    return "\n".join(lines + ["}};", "", "}  // namespace haptometer::dsp", ""])


def main():
    if "--check" not in sys.argv[1:]:
        TARGET.write_text(text())
        return 0
    kept = TARGET.read_text()
    if kept.split() == text().split():
        return 0
    print(f"{TARGET.name} is not what this script makes")
    return 1


if __name__ == "__main__":
    sys.exit(main())
