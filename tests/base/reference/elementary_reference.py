#!/usr/bin/env python3
"""Writes tests/base/reference/elementary_reference.csv: elementary functions to some 0.0001 ulp.

    elementary_reference.py             writes it (mpmath, 40 digits and more)
    elementary_reference.py --check     computes it anew and compares; 77 without mpmath

A row is the function, its arguments x and y (0 where it takes one), the double nearest to the exact result, the exponent
of that double's last bit, and the exact result's distance from it in units of that bit.
"""
import math
import pathlib
import random
import sys

try:
    from mpmath import mp, mpf
except ImportError:
    print("needs python3-mpmath")
    sys.exit(77)

mp.prec = 160
TARGET = pathlib.Path(__file__).with_name("elementary_reference.csv")
RANDOM = random.Random(20130613)
LARGEST = sys.float_info.max
LEAST_NORMAL = sys.float_info.min
LEAST = 5e-324
HALF_PI = math.pi / 2
# farther from a multiple of pi/2 no double is nearer: found by the continued fraction of pi/2
NEAR_QUARTER = (6381956970095103 * 2.0 ** 797, 5319372648326541 * 2.0 ** 416, 8139666055761541 * 2.0 ** -5)


def neighbours(value):
    return [math.nextafter(value, -math.inf), value, math.nextafter(value, math.inf)]


def between(lower, upper, count):
    return [RANDOM.uniform(lower, upper) for _ in range(count)]


def sizes(lower, upper, count):
    """Of evenly distributed exponents of 2."""
    return [RANDOM.uniform(1, 2) * 2.0 ** RANDOM.randint(lower, upper) for _ in range(count)]


def signed(values):
    return [sign * value for value in values for sign in (1, -1)]


def angles():
    values = between(-7, 7, 30) + sizes(-1020, -1, 10) + sizes(0, 1022, 30) + list(NEAR_QUARTER)
    for k in [1, 2, 3, 4, 7, 1001, 123457, 5340353, 5340354] + [RANDOM.randint(1, 5000000) for _ in range(10)]:
        values += neighbours(k * HALF_PI)
    for exponent in (24, 60, 200, 1000):
        values += neighbours(RANDOM.randint(2 ** 30, 2 ** 31) * HALF_PI * 2.0 ** (exponent - 31))
    values += neighbours(HALF_PI / 2) + neighbours(2.0 ** 23) + neighbours(2.0 ** -27)
    return values + [LARGEST, LEAST_NORMAL, LEAST, 1e-310]


def one_argument():
    """Function by its name, its exact counterpart, and arguments."""
    positive = (sizes(-1074, 1022, 30) + between(0.5, 2, 30) + [LEAST, 1e-310, LEAST_NORMAL, LARGEST, 0.5, 2.0, 10.0]
                + neighbours(1.0) + neighbours(0.703125) + neighbours(1.40625)
                + [1 + RANDOM.uniform(-1, 1) * 2.0 ** -k for k in range(3, 52, 3)])
    small = signed(sizes(-1074, -1, 10) + [LEAST, 1e-310, LEAST_NORMAL])
    growing = small + between(-40, 40, 30) + between(-1, 1, 20)
    ends = neighbours(709.782712893384) + neighbours(-708.3964185322641) + neighbours(-745.1332191019411)
    return {
        "Exp": (mp.exp, growing + between(-745, 709, 20) + ends + [-744.4400719213812, -720.0, -730.25]),
        "Expm1": (mp.expm1, growing + between(-1, 709, 10) + ends[:3] + neighbours(0.0625) + neighbours(-0.0625)),
        "Log": (mp.log, positive),
        "Log1p": (mp.log1p, small + between(-0.01, 0.01, 20) + between(-1, 1, 20) + sizes(0, 1022, 10)
                  + neighbours(2.0 ** -8) + neighbours(-(2.0 ** -8)) + [math.nextafter(-1, 0)]),
        "Log10": (mp.log10, positive + [10.0 ** k for k in range(-22, 23, 4)]),
        "Sinh": (mp.sinh, growing + between(-710, 710, 10) + neighbours(0.3) + neighbours(710.4758600739439)),
        "Asinh": (mp.asinh, growing + signed(sizes(0, 1022, 10)) + neighbours(0.25) + neighbours(2.0 ** 28)),
        "Cbrt": (mp.cbrt, positive + [27.0, 125.0, 343.0]),
        "Erfc": (mp.erfc, small + between(-6, 6, 40) + between(5, 27.2, 20) + neighbours(0.5) + neighbours(-0.5)
                 + neighbours(1.0) + [26.5, 26.6, 27.0, 27.2]),
        "Sin": (mp.sin, angles()),
        "Cos": (mp.cos, angles()),
        "Tan": (mp.tan, angles()),
    }


def powers():
    pairs = [(x, y) for x in (0.1, 0.5, 0.99, 1.01, 1.75, 10.0, 123.25) for y in (-40.0, -2.5, -1.0, 1 / 3, 2.0, 17.0)]
    for x in sizes(-1074, 1022, 20) + between(0.98, 1.02, 20):
        pairs.append((x, RANDOM.uniform(-745, 709) / math.log(x)))
    for x in (1.0000000001, 0.9999999999, math.nextafter(1, 2), math.nextafter(1, 0)):
        pairs += [(x, RANDOM.uniform(-700, 700) / (x - 1)) for _ in range(5)]
    pairs += [(-x, float(k)) for x in (0.3, 1.5, 1e5) for k in (-7, -4, 3, 10)]
    return pairs + [(2.0, -1074.0), (2.0, 1023.0), (10.0, -320.5), (10.0, 308.25), (3.0, 33.0), (2.0, 1e-20)]


def points():
    pairs = [(y, x) for y, x in zip(sizes(-1074, 1020, 30), sizes(-1074, 1020, 30))]
    for y, x in zip(between(-2, 2, 60), between(-2, 2, 60)):
        pairs += [(y, x), (y * 2.0 ** -RANDOM.randint(1, 60), x)]
    pairs += [(x * (1 + RANDOM.uniform(-1, 1) * 2.0 ** -20), -x) for x in sizes(-1000, 1000, 10)]
    return pairs + [(3.0, 4.0), (LEAST, LEAST), (LARGEST / 2, LARGEST / 2), (1e-310, -2e-310), (LEAST, -1.0)]


def row(name, x, y, exact):
    """None where the exact result is 0 or beyond doubles."""
    if exact == 0:
        return None
    last = max(int(mp.floor(mp.log(abs(exact), 2))) - 52, -1074)
    scaled = exact / mpf(2) ** last
    if abs(scaled) >= 2 ** 53:
        last, scaled = last + 1, scaled / 2
    if abs(scaled) < 2 ** 52 and last > -1074:
        last, scaled = last - 1, scaled * 2
    whole = int(mp.nint(scaled))
    if last + 53 > 1024 or abs(whole) * 2 ** max(last, 0) >= 2 ** 1024:
        return None
    nearest = math.ldexp(whole, last)
    return f"{name},{x.hex()},{y.hex()},{nearest.hex()},{last},{float(scaled - whole):.4f}"


def table():
    rows = []
    for name, (function, arguments) in one_argument().items():
        rows += [row(name, x, 0.0, function(mpf(x))) for x in arguments]
    rows += [row("Pow", x, y, mp.power(mpf(x), mpf(y))) for x, y in powers()]
    rows += [row("Hypot", x, y, mp.hypot(mpf(x), mpf(y))) for x, y in points()]
    # Atan2(x, y)
    rows += [row("Atan2", y, x, mp.atan2(mpf(y), mpf(x))) for y, x in points()]
    return "function,x,y,nearest,last,distance\n" + "".join(f"{line}\n" for line in rows if line)


if "--check" in sys.argv:
    if TARGET.read_text(encoding="utf-8") != table():
        sys.exit(f"{TARGET} is not what this script writes")
else:
    TARGET.write_text(table(), encoding="utf-8")
