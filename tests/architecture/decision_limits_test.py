"""Reads dsp/analysis/: a number that decides something stands in decision_limits.h, of which there are 40 at most,
each used, and each with a test that measures it. Every other number, named or in an expression, is in the lists
below: it is mathematics, or a size that changes no answer beyond its stated uncertainty."""
import pathlib
import re
import sys
import os

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import check

ROOM = pathlib.Path("dsp/analysis")
LIMITS = ROOM / "decision_limits.h"
MOST = 40

# quantiles, window coefficients, definitions of a method, limits of floating-point numbers
MATHEMATICS = {
    "band_analysis.cc": {"kFarthestM"},  # its fourth power is a number
    "band_noise.cc": {"kCorrelatedBins", "kTaperPower", "kTerms", "kLeftOut"},
    "drive_channel.cc": {"kCoarseSteps", "kRounding", "kDriveLevel"},  # one step; rounding; 10 % of a 10-90 % rise
    "drive_states.cc": {"kTwoPi"},
    "hum.cc": {"kTwoPi"},
    "hum.h": {"kMainsHz"},
    "record_facts.cc": {"kScalloped", "kPauseIntervals", "kLeastBeside"},  # what a pause is; chance below 1e-3
    "rms_estimate.cc": {"kNormal90", "kToneDegrees", "kManyDegrees", "kLeastDegrees"},
    "rms_estimate.h": {"kRmsCauseCount"},
    "sweep_analysis.cc": {"kFastest"},  # where a series stops to converge
    "window_choice.cc": {"kBlockLengths"},
    "window_states.h": {"kUnknownPause"},
    "window_tone.cc": {"kTwoPi", "kCoverage"},
}
# memory, speed, and what is left out because it is below the accuracy that is stated beside it
SIZES = {
    "band_filtering.cc": {"kMostModelled", "kMostSearched", "kLeastSearched", "kSearchedRatePerLower", "kPiece"},
    "band_noise.cc": {"kFootFrom", "kSteps", "kFolded", "kLeastSamples", "kRatePerUpper"},
    "band_signal.cc": {"kMostKept", "kThinnedAtOnce", "kLongestCellS", "kMostCells"},
    "drive_states.cc": {"kRatePerUpper", "kMostValues", "kMostInFrames", "kLeastSamples"},
    "hum.cc": {"kMostMultiples", "kBlock"},
    "record_facts.cc": {"kLeastBlock", "kMostBlocks", "kMost", "kSteps"},
    "sensor_gain.cc": {"kGridSteps"},
    "sweep_analysis.cc": {"kMostSamples"},
    "window_choice.h": {"kMostFitted", "kFittedOfLonger"},
    "window_bounds.cc": {"kMostForSteps"},
    "window_numbers.cc": {"kBesideRows"},
}
# sizes of an estimate: what they cost is in its standard uncertainty or its bound
ESTIMATES = {
    "band_noise.cc": {"kBinsOnASide", "kBinsOfPart", "kPartRatio"},
    "sweep_analysis.cc": {"kLongestSegmentS", "kSegmentsInRecord"},
}
# numbers in expressions beside these, with their reason
PLAIN = {"0", "1", "2", "3", "4", "12", "0.5"}
LITERALS = {
    "band_filtering.cc": {"1e-12"},  # to which a transient decays
    "band_noise.cc": {"0.999", "2.08"},  # rounding; 1 / ln(2)^2 of a median
    "band_noise.h": {"1.5"},  # reach of the filter's skirt
    # quantiles for the largest level and the least residual; parameters of a change, and their sums; a block that
    # is longer by less serves as well
    "drive_states.cc": {"0.95", "0.25", "5", "1.2", "1e-12", "1e-300"},
    "record_facts.cc": {"0.25"},  # steps of a bin
    "rms_estimate.cc": {"0.04", "0.025", "0.05"},  # tails of 95 %
    "sensor_gain.cc": {"1e+06"},
    "sweep_analysis.cc": {"60", "8"},  # bisection, samples
    "window_states.cc": {"1e-300"},
    "window_tone.cc": {"1e-300", "10.5"},  # the tenth harmonic
}

CONSTANT = re.compile(r"\b(?:constexpr|const|static)\s+(?:constexpr\s+)?(?:double|float|int|unsigned|bool|std::size_t|"
                      r"std::ptrdiff_t|std::u?int\d+_t|std::array<(?:double|int)[^>]*>)\s+(k[A-Z]\w*)\s*(?:=|\{)")
NUMBER = re.compile(r"(?<![\w.])(\d[\d'.]*(?:e[+-]?\d+)?)[UuLf]*(?![\w.])")
CASE = re.compile(r"^(?:TEST|TEST_F|TEST_P)\(\s*(\w+),\s*(\w+)", re.MULTILINE)


def without_text(source):
    return re.sub(r'//[^\n]*|"(?:\\.|[^"\\\n])*"|#include[^\n]*', "", source)


def constants(source):
    return CONSTANT.findall(without_text(source))


def literals(source):
    """Numbers outside of the definitions of constants."""
    code = re.sub(r"\bconstexpr\b[^;{]*=[^;]*;|\bconstexpr std::array[^;]*;", "", without_text(source))
    return {f"{float(number.replace(chr(39), '')):g}" for number in NUMBER.findall(code)} - PLAIN


def limits(header):
    """(name, comment above it) of each; several may follow one comment."""
    found, comment, was_comment = [], "", False
    for line in header.splitlines():
        if line.startswith("///"):
            comment = comment + " " + line[3:].strip() if was_comment else line[3:].strip()
        elif match := re.match(r"inline constexpr [\w:]+ (k\w+) = ", line):
            found.append((match[1], comment))
        elif not line.strip():
            comment = ""
        was_comment = line.startswith("///")
    return found


def check_search():
    check(constants("constexpr double kFoot = 2;\nconst int kLeast{3}; // constexpr int kNone = 1;") == ["kFoot", "kLeast"],
          "the search misses a constant")
    check(literals("constexpr double kA = 7;\nif (x > 1.25 + 2 / y) z = 0.5; // 9") == {"1.25"},
          "the search misses a number in an expression")
    check(limits("/// a\n/// Test: A.B\ninline constexpr int kA = 1;\ninline constexpr int kB = 1;\n\ninline constexpr int kC = 1;")
          == [("kA", "a Test: A.B"), ("kB", "a Test: A.B"), ("kC", "")], "the search misses a limit")


def check_room():
    sources = {path: path.read_text(encoding="utf-8") for path in sorted(ROOM.rglob("*.*")) if path != LIMITS}
    check(len(sources) > 20, f"{len(sources)} sources")
    wrong = []
    for path, source in sources.items():
        allowed = set().union(*(group.get(path.name, set()) for group in (MATHEMATICS, SIZES, ESTIMATES)))
        named = set(constants(source))
        wrong += [f"{path}: {name} decides something? then it stands in {LIMITS}" for name in sorted(named - allowed)]
        wrong += [f"{path}: {name} is listed here and is none" for name in sorted(allowed - named)]
        used = literals(source)
        wrong += [f"{path}: {number} in an expression" for number in sorted(used - LITERALS.get(path.name, set()))]
        wrong += [f"{path}: {number} is listed here and is none"
                  for number in sorted(LITERALS.get(path.name, set()) - used)]
    check(not wrong, "\n".join(wrong))
    return sources


def check_limits(sources):
    header = LIMITS.read_text(encoding="utf-8")
    found = limits(header)
    check(len(found) == len(re.findall(r"\bconstexpr\b", without_text(header))), "a limit without a line of its own")
    check(0 < len(found) <= MOST, f"{len(found)} limits, {MOST} at most")
    cases = {f"{suite}.{name}" for path in pathlib.Path("tests").rglob("*.cc")
             for suite, name in CASE.findall(path.read_text(encoding="utf-8"))}
    for name, comment in found:
        test = re.search(r"Test:\s*(\w+\.\w+)", comment)
        check(test and test[1] in cases, f"{name}: no test that exists ('{test[1] if test else ''}')")
        check(any(re.search(rf"\b{name}\b", without_text(source)) for source in sources.values()), f"{name} is not used")


check_search()
check_limits(check_room())
