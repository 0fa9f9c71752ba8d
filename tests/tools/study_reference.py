#!/usr/bin/env python3
"""Writes tests/tools/study_reference.csv: what `study matching` and `study linearity` must find.

    study_reference.py             writes it (SciPy)
    study_reference.py --check     computes it anew with SciPy and compares; 77 without SciPy
    study_reference.py --check-r   the same with R's t.test, p.adjust and lm; 77 without R

Shares nothing with tools/ and dsp/. Matching: fixtures/matching.csv, whole and with the rows left out
whose number (from 0) is 3 modulo 7; contrasts ia1:stock and ia2:cone. Linearity: 40 sweeps from integer
congruential noise (a draw is 0 to 1 in steps of 2^-23; sweep T starts the generator with T + 1): levels
1, 1.5, 2 ... V, 4 + T mod 9 of them, RMS / um = 8 v + (T mod 5 - 2) / 10 x v^2 + 1 + draw.
"""
import csv
import itertools
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/dsp/statistics"))
from tables_reference import critical, draws, interval, np, stats  # noqa: E402 (exits with 77 without SciPy)

TARGET = pathlib.Path(__file__).with_name("study_reference.csv")
SWEEPS = 40
CONTRASTS = (("ia1", "stock"), ("ia2", "cone"))


def settings(gaps):
    lines = [line for line in (ROOT / "fixtures/matching.csv").read_text().splitlines() if line[0] != "#"]
    rows = list(csv.DictReader(lines))
    return [row for number, row in enumerate(rows) if not (gaps and number % 7 == 3)]


def mean_logs(rows):
    """{condition: {(level, subject): ln r}}, each start counting alike."""
    key = lambda row: (row["condition"], row["reference_v"], row["subject"])  # noqa: E731
    logs = {}
    for (condition, level, subject), group in itertools.groupby(sorted(rows, key=key), key):
        starts = {}
        for row in group:
            starts.setdefault(row["started"], []).append(math.log(float(row["matched_v"]) / float(level)))
        logs.setdefault(condition, {})[level, subject] = np.mean([np.mean(each) for each in starts.values()])
    return logs


def levels_of(logs):
    """The values a subject, by level and over all levels."""
    levels = sorted({level for level, _ in logs})
    values = {level: [log for (l, _), log in logs.items() if l == level] for level in levels}
    subjects = sorted({subject for _, subject in logs})
    values["all"] = [np.mean([log for (_, s), log in logs.items() if s == subject]) for subject in subjects]
    return {level: np.array(each) for level, each in values.items()}


def groups(gaps):
    """{condition or contrast: {level or all: logarithms}}"""
    logs = mean_logs(settings(gaps))
    found = {name: levels_of(each) for name, each in logs.items()}
    for treatment, control in CONTRASTS:
        both = logs[treatment].keys() & logs[control].keys()
        found[f"{treatment}:{control}"] = levels_of({k: logs[treatment][k] - logs[control][k] for k in both})
    return found


def holm(p):
    """By its definition: the largest of what the smaller ones became."""
    return [max(min(1, sum(other >= one for other in p) * one) for one in p if one <= mine) for mine in p]


def ratio(values):
    t, p = stats.ttest_1samp(values, 0)
    return {"n": len(values), "ratio": math.exp(values.mean()), "lower": math.exp(interval(values)[0]),
            "upper": math.exp(interval(values)[1]), "t": t, "p": p}


def matching(ratio_of, holm_of):
    found = {}
    for case, gaps in (("whole", False), ("gaps", True)):
        by_name = {name: {level: ratio_of(values) for level, values in levels.items()}
                   for name, levels in groups(gaps).items()}
        for levels in by_name.values():
            single = [each for level, each in levels.items() if level != "all"]
            for each, p in zip(single, holm_of([each["p"] for each in single]), strict=True):
                each["p_holm"] = p
        wholes = [by_name[f"{a}:{b}"]["all"] for a, b in CONTRASTS]
        for each, p in zip(wholes, holm_of([each["p"] for each in wholes]), strict=True):
            each["p_holm"] = p
        for name, levels in by_name.items():
            for level, each in levels.items():
                found |= {f"{case}/{name}/{level}/{what}": value for what, value in each.items()}
    return found


def sweep(number):
    draw = draws(number + 1)
    v = np.array([1 + 0.5 * k for k in range(4 + number % 9)])
    return v, np.array([8 * x + ((number % 5 - 2) / 10) * x * x + 1 + next(draw) for x in v])


def line(number):
    v, um = sweep(number)
    fit = stats.linregress(v, um)
    reach = critical(len(v) - 2) * fit.stderr
    residual = um - fit.intercept - fit.slope * v
    # the parabola on columns of length 1 that do not overlap
    q = np.linalg.qr(np.vander(v - v.mean(), 3, increasing=True))
    coefficients = q[0].T @ um
    scale = q[1][2, 2]
    left = um - q[0] @ coefficients
    stderr = math.sqrt(left @ left / (len(v) - 3)) / abs(scale)
    bend = coefficients[2] / scale
    return {"slope": fit.slope, "slope_lower": fit.slope - reach, "slope_upper": fit.slope + reach,
            "r_squared": 1 - residual @ residual / ((um - um.mean()) @ (um - um.mean())),
            "largest": abs(residual).max(),
            "curvature": bend, "curvature_lower": bend - critical(len(v) - 3) * stderr,
            "curvature_upper": bend + critical(len(v) - 3) * stderr, "curvature_t": bend / stderr,
            "curvature_p": 2 * stats.t.sf(abs(bend / stderr), len(v) - 3)}


def linearity():
    return {f"sweep/{number}/{what}": float(value)
            for number in range(SWEEPS) for what, value in line(number).items()}


R_SCRIPT = r"""
folder <- commandArgs(TRUE)[1]
say <- function(key, values) cat(sprintf("%s/%s,%.17g\n", key, names(values), values), sep = "")
groups <- read.csv(file.path(folder, "groups.csv"))
for (key in unique(groups$key)) {
  x <- groups$value[groups$key == key]
  test <- t.test(x)
  say(key, c(n = length(x), ratio = exp(mean(x)), lower = exp(test$conf.int[1]),
             upper = exp(test$conf.int[2]), t = unname(test$statistic), p = test$p.value))
}
sweeps <- read.csv(file.path(folder, "sweeps.csv"))
for (number in unique(sweeps$number)) {
  one <- sweeps[sweeps$number == number, ]
  fit <- lm(um ~ v, one)
  ends <- confint(fit)
  one$w <- one$v - mean(one$v)
  bent <- lm(um ~ w + I(w^2), one)
  bend <- summary(bent)$coefficients[3, ]
  say(paste0("sweep/", number),
      c(slope = unname(coef(fit)[2]), slope_lower = ends[2, 1], slope_upper = ends[2, 2],
        r_squared = summary(fit)$r.squared, largest = max(abs(resid(fit))), curvature = unname(bend[1]),
        curvature_lower = confint(bent)[3, 1], curvature_upper = confint(bent)[3, 2],
        curvature_t = unname(bend[3]), curvature_p = unname(bend[4])))
}
"""


def of_r():
    """As far as R goes by itself; Holm by p.adjust, asked once a list."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        with (folder / "groups.csv").open("w") as file:
            file.write("key,value\n")
            for case, gaps in (("whole", False), ("gaps", True)):
                for group, levels in groups(gaps).items():
                    for level, values in levels.items():
                        file.writelines(f"{case}/{group}/{level},{value!r}\n" for value in values.tolist())
        with (folder / "sweeps.csv").open("w") as file:
            file.write("number,v,um\n")
            for number in range(SWEEPS):
                file.writelines(f"{number},{v!r},{um!r}\n" for v, um in zip(*map(np.ndarray.tolist, sweep(number))))
        (folder / "study.R").write_text(R_SCRIPT)
        run = subprocess.run(["Rscript", "--vanilla", folder / "study.R", folder], capture_output=True, text=True)
        if run.returncode != 0:
            sys.exit(run.stderr)
    found = {key: float(value) for key, value in (line.split(",") for line in run.stdout.splitlines())}
    asked = iter([])

    def ratio_of_r(_):
        return next(asked)

    order = [f"{case}/{group}/{level}" for case, gaps in (("whole", False), ("gaps", True))
             for group, levels in groups(gaps).items() for level in levels]
    asked = iter([{what: found[f"{key}/{what}"] for what in ("n", "ratio", "lower", "upper", "t", "p")}
                  for key in order])
    return matching(ratio_of_r, holm_of_r) | {key: value for key, value in found.items() if key.startswith("sweep")}


def holm_of_r(p):
    words = f"cat(sprintf('%.17g', p.adjust(c({','.join(map(repr, map(float, p)))}), 'holm')))"
    run = subprocess.run(["Rscript", "--vanilla", "-e", words], capture_output=True, text=True, check=True)
    return [float(word) for word in run.stdout.split()]


def compare(found, tolerance):
    kept = dict(line.split(",") for line in TARGET.read_text().splitlines()[1:])
    worst = 0.0
    if found.keys() != kept.keys():
        print(f"other quantities: {sorted(found.keys() ^ kept.keys())[:5]}")
        return 1
    for key, value in found.items():
        # a probability counts by itself; another number near 0 against a thousandth of its unit
        floor = 0.0 if key.endswith(("/p", "p_holm", "curvature_p")) else 1e-3
        residual = abs(value - float(kept[key])) / max(abs(float(kept[key])), floor)
        worst = max(worst, residual)
        if not residual <= tolerance:
            print(f"{key} is {value!r}, kept is {kept[key]}")
    print(f"{len(found)} numbers, worst relative difference {worst:.2g}")
    return 0 if worst <= tolerance else 1


def main():
    if "--check-r" in sys.argv[1:]:
        if shutil.which("Rscript") is None:
            print("needs r-base-core")
            return 77
        return compare(of_r(), 1e-10)
    found = matching(ratio, holm) | linearity()
    if "--check" in sys.argv[1:]:
        return compare(found, 1e-11)
    TARGET.write_text("# Made by tests/tools/study_reference.py with SciPy; that script says what it is\n"
                      + "".join(f"{key},{value:.16g}\n" for key, value in found.items()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
