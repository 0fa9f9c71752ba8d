"""Reads the symbols of archives: sim and dsp/filter, and what of base they use, call no function of the C library's
mathematics but those whose result is exact by definition. The others have variants that are chosen by the processor
and differ in the last bit; base/elementary_functions.h and base/circular_functions.h replace them.

    no_libm_test.py ARCHIVE...    the archives of base, dsp and sim
"""
import os
import re
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import check

# correctly rounded, or without rounding (C99, F.9; fma: F.9.10.1)
EXACT = ("ceil copysign fabs fdim floor fma fmax fmin fmod frexp ilogb ldexp llrint llround logb lrint lround modf nearbyint "
         "nextafter nexttoward remainder remquo rint round scalbln scalbn sqrt trunc").split()
OTHERS = ("acos acosh asin asinh atan atan2 atanh cbrt cos cosh erf erfc exp exp10 exp2 expm1 hypot j0 j1 jn lgamma lgamma_r "
          "log log10 log1p log2 pow sin sincos sinh tan tanh tgamma y0 y1 yn "
          "cabs cacos cacosh carg casin casinh catan catanh ccos ccosh cexp clog cpow csin csinh csqrt ctan ctanh").split()
WRONG = re.compile(rf"(?:__)?({'|'.join(OTHERS)})[fl]?(?:_finite)?(?:@.*)?")
# of dsp, the members of the folder filter
FILTER = re.compile(r"(butterworth|cascade|lane_cascade|transient|zero_phase|lane_kernel)\.cc\.o")


def calls(archive):
    """(member, name) of each symbol that the archive's members take from elsewhere."""
    listing = subprocess.run(["nm", "-A", "-u", archive], capture_output=True, text=True, check=True).stdout
    found = []
    for line in listing.splitlines():
        match = re.fullmatch(r".*:([^:]+\.o):\s+[Uw] (\S+)", line)
        check(match is not None, f"not understood: {line}")
        found.append((match[1], match[2]))
    return found


def wrong(found):
    return sorted({f"{member} calls {name}" for member, name in found if WRONG.fullmatch(name)})


def check_search():
    for name in ("sin", "sincos", "powl", "expf", "cabs", "csqrt", "__exp_finite", "hypot@GLIBC_2.35"):
        check(wrong([("a.o", name)]) == [f"a.o calls {name}"], f"the search misses {name}")
    for name in [*EXACT, "sqrtl", "roundl", "ldexpl", "memcpy", "_ZN10haptometer3SinEd", "__muldc3"]:
        check(not wrong([("a.o", name)]), f"{name} is exact")


def check_archives(base, dsp, sim):
    of_filter = [(member, name) for member, name in calls(dsp) if FILTER.fullmatch(member)]
    members = {member for member, _ in of_filter}
    check({"butterworth.cc.o", "transient.cc.o", "zero_phase.cc.o"} <= members, f"members of dsp/filter: {members}")
    lost = wrong(of_filter) + wrong(calls(sim)) + wrong(calls(base))
    check(not lost, "results that depend on the processor:\n" + "\n".join(lost))


check_search()
check_archives(*sys.argv[1:])
