#!/usr/bin/env python3
"""Writes base/elementary_tables.h: the polynomials and tables of base/elementary_functions.cc and
base/circular_functions.cc.

    elementary_tables.py             writes it
    elementary_tables.py --check     computes it anew and compares; 77 without mpmath

Polynomials have the least possible largest error relative to the function (Remez' exchange), those of erfc
interpolate at Chebyshev's points. A stated bound is the largest error over 2000 points with rounded coefficients.
"""
import pathlib
import sys

try:
    from mpmath import mp, mpf
except ImportError:
    print("needs python3-mpmath")
    sys.exit(77)

mp.prec = 240
TARGET = pathlib.Path(__file__).parents[3] / "base" / "elementary_tables.h"
ERF_SLOPE = 2 / mp.sqrt(mp.pi)


def rounded(value, bits=53):
    """The nearest number of `bits` significant bits."""
    with mp.workprec(bits):
        return +value


def multiple(value, unit):
    return mp.nint(value / unit) * unit


def text(value):
    return float(value).hex().replace(".0000000000000p", "p").replace("0x0.0p+0", "0")


def pair(value):
    high = rounded(value)
    return high, rounded(value - high)


def chebyshev(lower, upper, count):
    """The zeros of a Chebyshev polynomial, the middle one of an odd count a trifle aside: f(0) is 0/0."""
    middle, half = (mpf(lower) + upper) / 2, (mpf(upper) - lower) / 2
    return [middle + half * (mp.cos(mp.pi * (2 * k + 1) / (2 * count)) + mpf(2) ** -60) for k in range(count)]


def interpolated(function, lower, upper, degree):
    """Coefficients, lowest power first, of the polynomial through the function at Chebyshev's points."""
    nodes = chebyshev(lower, upper, degree + 1)
    return mp.lu_solve(mp.matrix([[z ** k for k in range(degree + 1)] for z in nodes]),
                       mp.matrix([function(z) for z in nodes]))


def minimax(function, weight, lower, upper, degree):
    """Coefficients of the polynomial p with the least largest |p - function| weight: Remez' exchange."""
    grid = chebyshev(lower, upper, 40 * (degree + 2))
    values, weights = [function(z) for z in grid], [weight(z) for z in grid]
    picked = [20 + 40 * k for k in range(degree + 2)]
    for _ in range(12):
        # p(z) - (-1)^j e / weight(z) = function(z) at degree + 2 points
        solution = mp.lu_solve(mp.matrix([[grid[at] ** k for k in range(degree + 1)] + [(-1) ** j / weights[at]]
                                          for j, at in enumerate(picked)]),
                               mp.matrix([values[at] for at in picked]))
        coefficients = list(solution)[:-1]
        errors = [(mp.polyval(coefficients[::-1], z) - value) * w for z, value, w in zip(grid, values, weights)]
        # the largest of each run of one sign
        runs = []
        for at, error in enumerate(errors):
            if runs and errors[runs[-1]] * error > 0:
                runs[-1] = max(runs[-1], at, key=lambda place: abs(errors[place]))
            else:
                runs.append(at)
        while len(runs) > degree + 2:
            runs.pop(0 if abs(errors[runs[0]]) < abs(errors[runs[-1]]) else -1)
        assert len(runs) == degree + 2, "the error alternates too seldom"
        if runs == picked:
            return coefficients
        picked = runs
    return coefficients


def largest_error(coefficients, function, weight, lower, upper, points=2000):
    """log2 of the largest |polynomial - function| weight."""
    largest = mpf(0)
    for k in range(points):
        z = lower + (mpf(upper) - lower) * (2 * k + 1) / (2 * points)
        largest = max(largest, abs(mp.polyval(coefficients[::-1], z) - function(z)) * weight(z))
    return mp.log(largest, 2)


def array(name, values, comment, columns=4):
    lines = [f"// {line}" for line in comment]
    lines.append(f"inline constexpr std::array<double, {len(values)}> {name}{{")
    for k in range(0, len(values), columns):
        lines.append("    " + ", ".join(text(v) for v in values[k:k + columns]) + ",")
    return lines + ["};", ""]


def bounded(name, function, weight, lower, upper, degree, what, where):
    """An array of a polynomial with its bound."""
    first = rounded(minimax(function, weight, lower, upper, degree)[0])
    # the others make up for what rounding the first one costs
    others = minimax(lambda z: (function(z) - first) / z, lambda z: abs(z) * weight(z), lower, upper, degree - 1)
    coefficients = [first] + [rounded(c) for c in others]
    bound = mp.ceil(10 * largest_error(coefficients, function, weight, lower, upper)) / 10
    return array(name, coefficients, [f"{what}, {where}; error below 2^{mp.nstr(bound, 3)} of the result"])


def of_square(function):
    """A function of z = x^2 for x > 0."""
    return lambda z: function(mp.sqrt(z))


def polynomials():
    step = mp.log(2) / 256 * (1 + mpf(2) ** -20)
    small = mpf(2) ** -7
    quarter = (mp.pi / 4) ** 2 * (1 + mpf(2) ** -20)
    third = mpf(3) / 10
    yield bounded("kExpTail", lambda r: (mp.expm1(r) - r) / r ** 2, lambda r: r ** 2, -step, step, 3,
                  "(e^r - 1 - r) / r^2", "|r| <= ln 2 / 256")
    yield bounded("kExpm1Tail", lambda x: (mp.expm1(x) - x - x ** 2 / 2) / x ** 3, lambda x: abs(x ** 3 / mp.expm1(x)),
                  -mpf(1) / 16, mpf(1) / 16, 6, "(e^x - 1 - x - x^2 / 2) / x^3", "|x| <= 1/16")
    yield bounded("kLogTail", lambda r: (mp.log1p(r) - r + r ** 2 / 2) / r ** 3, lambda r: abs(r ** 3 / mp.log1p(r)),
                  -small, small, 6, "(log(1 + r) - r + r^2 / 2) / r^3", "|r| <= 2^-7")
    yield bounded("kSinTail", of_square(lambda r: (mp.sin(r) - r) / r ** 3), of_square(lambda r: r ** 3 / mp.sin(r)),
                  mpf(0), quarter, 5, "(sin r - r) / r^3 in r^2", "|r| <= pi / 4")
    yield bounded("kCosTail", of_square(lambda r: (mp.cos(r) - 1 + r ** 2 / 2) / r ** 4),
                  of_square(lambda r: r ** 4 / mp.cos(r)), mpf(0), quarter, 5,
                  "(cos r - 1 + r^2 / 2) / r^4 in r^2", "|r| <= pi / 4")
    yield bounded("kSinhTail", of_square(lambda x: (mp.sinh(x) - x) / x ** 3), of_square(lambda x: x ** 3 / mp.sinh(x)),
                  mpf(0), third ** 2, 4, "(sinh x - x) / x^3 in x^2", "|x| <= 0.3")
    yield bounded("kAsinhTail", of_square(lambda x: (mp.asinh(x) - x) / x ** 3),
                  of_square(lambda x: x ** 3 / mp.asinh(x)), mpf(0), mpf(1) / 16, 8,
                  "(asinh x - x) / x^3 in x^2", "|x| <= 1/4")
    yield bounded("kAtanTail", of_square(lambda t: (mp.atan(t) - t) / t ** 3), of_square(lambda t: t ** 3 / mp.atan(t)),
                  mpf(0), (mpf(1) / 63) ** 2, 3, "(atan t - t) / t^3 in t^2", "|t| <= 1/63")
    yield bounded("kErfTail", of_square(lambda x: (mp.erf(x) - ERF_SLOPE * x) / x ** 3), of_square(lambda x: x ** 3),
                  mpf(0), mpf(1) / 4, 8, "(erf x - 2 x / sqrt(pi)) / x^3 in x^2", "|x| <= 1/2")
    yield bounded("kCbrtStart", mp.cbrt, lambda m: 1 / mp.cbrt(m), mpf(1), mpf(2), 3, "cbrt m", "1 <= m <= 2")


def constants():
    def high_and_low(name, value, bits):
        high = rounded(value, bits)
        return [f"inline constexpr double {name}High = {text(high)};",
                f"inline constexpr double {name}Low = {text(rounded(value - high))};"]

    lines = ["// ln 2 / 128, its high part of 35 bits; ln 2, its high part a multiple of 2^-42"]
    lines += high_and_low("kExpStep", mp.log(2) / 128, 35)
    lines += high_and_low("kLn2", mp.log(2), 42)
    lines.append(f"inline constexpr double kExpStepsPerUnit = {text(rounded(128 / mp.log(2)))};")
    lines += ["", "// 1 / ln 10; 2 / sqrt(pi); pi / 2"]
    lines += high_and_low("kPerLn10", 1 / mp.log(10), 53)
    lines += high_and_low("kErfSlope", ERF_SLOPE, 53)
    lines += high_and_low("kHalfPi", mp.pi / 2, 53)
    lines += ["", "// pi / 2 as a sum: two parts of 30 bits, and the rest"]
    first = multiple(mp.pi / 2, mpf(2) ** -29)
    second = multiple(mp.pi / 2 - first, mpf(2) ** -59)
    for name, value in (("First", first), ("Second", second), ("Third", rounded(mp.pi / 2 - first - second))):
        lines.append(f"inline constexpr double kHalfPi{name} = {text(value)};")
    lines.append(f"inline constexpr double kPerHalfPi = {text(rounded(2 / mp.pi))};")
    lines += ["", "// cbrt 1, 2, 4"]
    roots = ", ".join(text(rounded(mp.cbrt(2 ** k))) for k in range(3))
    return lines + [f"inline constexpr std::array<double, 3> kCbrtOfPowers{{{roots}}};", ""]


def bits_of_two_over_pi():
    with mp.workprec(1600):
        digits = int(mp.floor(2 / mp.pi * mpf(2) ** (32 * 40)))
    limbs = [digits >> (32 * (39 - k)) & 0xffffffff for k in range(40)]
    lines = ["// 2 / pi = sum of kBitsOfPerHalfPi[k] 2^(-32 (k + 1))",
             "inline constexpr std::array<std::uint32_t, 40> kBitsOfPerHalfPi{"]
    for k in range(0, 40, 8):
        lines.append("    " + ", ".join(f"0x{limb:08x}" for limb in limbs[k:k + 8]) + ",")
    return lines + ["};", ""]


def rows(name, kind, values, comment):
    lines = [f"// {line}" for line in comment]
    lines.append(f"inline constexpr std::array<{kind}, {len(values)}> {name}{{{{")
    lines += ["    {" + ", ".join(text(v) for v in row) + "}," for row in values]
    return lines + ["}};", ""]


def powers_of_two():
    values = []
    for k in range(128):
        exact = mpf(2) ** (mpf(k) / 128)
        high = rounded(exact)
        values.append((high, rounded((exact - high) / high)))
    return rows("kExpTable", "ExpRow", values, ["2^(k/128) = power (1 + tail)"])


# m = 1.40625 / 2 and above
LOG_BEGIN = mpf("0.703125")


def logarithms():
    """Each interval's inverse has so few bits that inverse m - 1 is exact in 53, which holds below 2^-7."""
    values = []
    lower = LOG_BEGIN
    for _ in range(128):
        width = mpf(2) ** -8 if lower < 1 else mpf(2) ** -7
        unit = mpf(2) ** -7 if lower < 1 else mpf(2) ** -8
        upper = lower + width
        inverse = mpf(1) if lower in (1, 1 - mpf(2) ** -8) else multiple(2 / (lower + upper), unit)
        farthest = max(abs(lower * inverse - 1), abs(upper * inverse - 1))
        assert farthest <= mpf(2) ** -7, (lower, farthest)
        logarithm = -mp.log(inverse)
        assert logarithm == 0 or abs(logarithm) > max(abs(lower * inverse - 1), abs(upper * inverse - 1)) * 0.9
        high = multiple(logarithm, mpf(2) ** -42)
        values.append((inverse, high, rounded(logarithm - high)))
        lower = upper
    assert lower == 2 * LOG_BEGIN
    return rows("kLogTable", "LogRow", values,
                ["interval k of 128, of equal steps of the bits from 0.703125 to 1.40625: inverse about 1/m, -log(inverse)",
                 "as a multiple of 2^-42 and the rest. inverse m - 1 is below 2^-7 and exact: inverse is a multiple of 2^-7",
                 "below m = 1, of 2^-8 above."])


def arctangents():
    return rows("kAtanTable", "AtanRow", [pair(mp.atan(mpf(k) / 32)) for k in range(33)],
                ["atan(k/32) = high + low"])


ERFC_DEGREE = 14


def scaled_erfc():
    """Four intervals an octave from 1/2 to 32."""
    function = lambda x: mp.exp(x ** 2) * mp.erfc(x)
    values, worst = [], mp.ninf
    with mp.workprec(400):
        for k in range(24):
            octave = mpf(2) ** (k // 4 - 1)
            lower, upper = octave * (1 + mpf(k % 4) / 4), octave * (1 + mpf(k % 4 + 1) / 4)
            middle = (lower + upper) / 2
            # the value at the middle apart: the other coefficients are those of (g(x) - g(middle)) / t
            value = function(middle)
            slope = lambda t: (function(middle + t) - value) / t if t else mp.diff(function, middle)
            half = (upper - lower) / 2
            coefficients = [rounded(c) for c in interpolated(slope, -half, half, ERFC_DEGREE - 1)]
            error = largest_error(coefficients, slope, lambda t: abs(t / function(middle + t)), -half, half, 40)
            worst = max(worst, error)
            values.append([*pair(value)] + coefficients)
    bound = mp.nstr(mp.ceil(10 * worst) / 10, 3)
    lines = ["// e^(x^2) erfc x, four intervals an octave from 1/2 to 32: at the middle, high + low, and further",
             f"// coefficients of powers of t = x - middle; error below 2^{bound}",
             f"inline constexpr std::array<ErfcRow, {len(values)}> kErfcTable{{{{"]
    for row in values:
        lines.append(f"    {{{text(row[0])}, {text(row[1])},")
        tail = [text(v) for v in row[2:]]
        lines.append("     {" + ",\n      ".join(", ".join(tail[j:j + 4]) for j in range(0, len(tail), 4)) + "}},")
    return lines + ["}};", ""]


HEAD = """#pragma once

// Written by tests/base/reference/elementary_tables.py, which derives each number; do not edit.

#include <array>
#include <cstdint>

// clang-format off
namespace haptometer::elementary {

struct ExpRow {
  double power;
  double tail;
};

struct LogRow {
  double inverse;
  double high;
  double low;
};

struct AtanRow {
  double high;
  double low;
};

struct ErfcRow {
  double high;
  double low;
  std::array<double, 14> slopes;
};
"""


def header():
    lines = [HEAD]
    lines += constants()
    for part in polynomials():
        lines += part
    for part in (bits_of_two_over_pi(), powers_of_two(), logarithms(), arctangents(), scaled_erfc()):
        lines += part
    return "\n".join(lines) + "}  // namespace haptometer::elementary\n// clang-format on\n"


if "--check" in sys.argv:
    if TARGET.read_text(encoding="utf-8") != header():
        sys.exit(f"{TARGET} is not what this script writes")
else:
    TARGET.write_text(header(), encoding="utf-8")
