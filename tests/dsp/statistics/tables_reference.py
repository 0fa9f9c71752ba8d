#!/usr/bin/env python3
"""Writes tests/dsp/statistics/tables_reference.csv: what 200 random tables give.

    tables_reference.py             writes it (SciPy)
    tables_reference.py --check     computes it anew with SciPy and compares; 77 without SciPy
    tables_reference.py --check-r   the same with R's own t.test, aov and pt; 77 without R

Shares nothing with dsp/. The tables come from integer congruential noise, so both sides have them
to the last bit: table T has 3 + T mod 22 subjects, 2 + T mod 5 conditions and starts the generator
with T + 1. Value (s, c), drawn subject by subject: 16 + subject + condition x effect + noise, where
a draw is 0 to 1 in steps of 2^-23, subject = 8 x draw, noise = 4 x draw and effect = (T mod 7) / 4.

Compared are conditions 1 and 0 (t, p, interval, Hedges g and the interval of the standardized
difference, ratio of geometric means, Fieller's interval), and all conditions (F, p, epsilon).
"""

import csv
import io
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile

try:
    import numpy as np
    from scipy import optimize, special, stats
except ImportError as missing:
    print(f"needs python3-scipy: {missing}")
    sys.exit(77)

TABLES = 200
TARGET = pathlib.Path(__file__).with_name("tables_reference.csv")
COLUMNS = ("table,subjects,conditions,t,p,difference_lower,difference_upper,g,effect_lower,effect_upper,"
           "ratio,ratio_p,ratio_lower,ratio_upper,fieller_lower,fieller_upper,f,f_p,epsilon,epsilon_p"
           ).split(",")


def draws(seed):
    x = seed
    while True:
        x = (1103515245 * x + 12345) % 2**31
        yield (x >> 8) / 2**23


def table(number):
    draw = draws(number + 1)
    rows = []
    for _ in range(3 + number % 22):
        subject = 8 * next(draw)
        rows.append([16 + subject + c * ((number % 7) / 4) + 4 * next(draw)
                     for c in range(2 + number % 5)])
    return np.array(rows)


NODES, WEIGHTS = np.polynomial.legendre.leggauss(400)


def critical(df):
    """SciPy's quantile, good to 1e-9 only, with two steps of Newton on its distribution."""
    t = stats.t.ppf(0.975, df)
    for _ in range(2):
        t -= (0.025 - stats.t.sf(t, df)) / stats.t.pdf(t, df)
    return t


def interval(values):
    reach = critical(len(values) - 1) * stats.sem(values)
    return values.mean() - reach, values.mean() + reach


def noncentral_upper(t, df, delta):
    """P(T >= t): the normal tail, averaged over the chi distribution of sqrt(chi2 / df)."""
    top = 1 + 40 / math.sqrt(df)
    s = (NODES + 1) / 2 * top
    log_density = (math.log(2) + df / 2 * math.log(df / 2) - special.gammaln(df / 2)
                   + (df - 1) * np.log(s) - df * s * s / 2)
    return float(np.sum(WEIGHTS * np.exp(log_density) * special.ndtr(delta - t * s)) * top / 2)


def noncentrality(t, df):
    ends = []
    for tail in (0.025, 0.975):
        ends.append(optimize.brentq(lambda d: noncentral_upper(t, df, d) - tail, t - 40 - 4 * abs(t),
                                    t + 40 + 4 * abs(t), xtol=1e-13, rtol=1e-14))
    return ends


def fieller(a, b):
    """The roots, or two empty cells where the set is unbounded."""
    n = len(a)
    c = critical(n - 1) ** 2 / n
    covariance = np.cov(a, b)
    roots = np.roots([b.mean() ** 2 - c * covariance[1, 1],
                      -2 * (a.mean() * b.mean() - c * covariance[0, 1]),
                      a.mean() ** 2 - c * covariance[0, 0]])
    bounded = b.mean() ** 2 > c * covariance[1, 1]
    return sorted(roots.real) if bounded else [math.nan, math.nan]


def anova(values):
    n, k = values.shape
    grand = values.mean()
    conditions = n * ((values.mean(axis=0) - grand) ** 2).sum()
    residual = values - values.mean(axis=0) - values.mean(axis=1)[:, None] + grand
    f = (conditions / (k - 1)) / ((residual**2).sum() / ((k - 1) * (n - 1)))
    # epsilon from the eigenvalues of orthonormal contrasts' covariance, not from the double centring
    contrasts = np.linalg.qr(np.column_stack([np.ones(k), np.eye(k)[:, : k - 1]]))[0][:, 1:]
    eigenvalues = np.linalg.eigvalsh(np.atleast_2d(np.cov(values @ contrasts, rowvar=False)))
    epsilon = eigenvalues.sum() ** 2 / ((k - 1) * (eigenvalues**2).sum())
    df = np.array([k - 1, (k - 1) * (n - 1)])
    return [f, stats.f.sf(f, *df), epsilon, stats.f.sf(f, *(epsilon * df))]


def row(number):
    values = table(number)
    n, k = values.shape
    b, a = values[:, 0], values[:, 1]
    df = n - 1
    t, p = stats.ttest_rel(a, b)
    difference = a - b
    low, high = interval(difference)
    correction = math.exp(special.gammaln(df / 2) - special.gammaln((df - 1) / 2)) / math.sqrt(df / 2)
    effect = [end / math.sqrt(n) for end in noncentrality(t, df)]
    logs = np.log(a) - np.log(b)
    ratio = stats.ttest_1samp(logs, 0)
    ratio_ends = np.exp(interval(logs))
    return [number, n, k, t, p, low, high, correction * difference.mean() / difference.std(ddof=1),
            *effect, math.exp(logs.mean()), ratio.pvalue, *ratio_ends, *fieller(a, b), *anova(values)]


R_SCRIPT = """
tables <- read.csv(commandArgs(TRUE)[1])
for (number in unique(tables$table)) {
  long <- tables[tables$table == number, ]
  a <- long$value[long$condition == 1]
  b <- long$value[long$condition == 0]
  n <- length(a)
  test <- t.test(a, b, paired = TRUE)
  t <- unname(test$statistic)
  end <- function(tail) uniroot(function(d) pt(t, n - 1, d, lower.tail = FALSE) - tail,
    c(t - 6 - abs(t), min(37, t + 6 + abs(t))), tol = 1e-14, extendInt = "upX")$root
  j <- gamma((n - 1) / 2) / (sqrt((n - 1) / 2) * gamma((n - 2) / 2))
  ratio <- t.test(log(a), log(b), paired = TRUE)
  fit <- summary(aov(value ~ factor(condition) + Error(factor(subject)), data = long))
  inner <- fit[["Error: Within"]][[1]]
  k <- max(long$condition) + 1
  wide <- matrix(long$value, nrow = n, byrow = TRUE)
  centre <- diag(k) - 1 / k
  s <- centre %*% cov(wide) %*% centre
  epsilon <- sum(diag(s))^2 / ((k - 1) * sum(s^2))
  f <- inner[["F value"]][1]
  cat(sprintf("%.17g", c(number, n, k, t, test$p.value, test$conf.int, j * mean(a - b) / sd(a - b),
      end(0.025) / sqrt(n), end(0.975) / sqrt(n), exp(mean(log(a) - log(b))), ratio$p.value,
      exp(ratio$conf.int), NA, NA, f, inner[["Pr(>F)"]][1], epsilon,
      pf(f, epsilon * (k - 1), epsilon * (k - 1) * (n - 1), lower.tail = FALSE))), sep = ",")
  cat("\\n")
}
"""


def rows_of_r():
    with tempfile.TemporaryDirectory() as folder:
        data, script = pathlib.Path(folder, "tables.csv"), pathlib.Path(folder, "tables.R")
        with data.open("w") as file:
            file.write("table,subject,condition,value\n")
            for number in range(TABLES):
                for (s, c), value in np.ndenumerate(table(number)):
                    file.write(f"{number},{s},{c},{value!r}\n")
        script.write_text(R_SCRIPT)
        run = subprocess.run(["Rscript", "--vanilla", script, data], capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(run.stderr)
    return [[math.nan if cell == "NA" else float(cell) for cell in line.split(",")]
            for line in run.stdout.splitlines()]


def written(rows):
    text = io.StringIO()
    text.write("# Made by tests/dsp/statistics/tables_reference.py with SciPy; that script says what it is\n")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for cells in rows:
        writer.writerow(["" if math.isnan(c) else repr(c) if i < 3 else format(c, ".16g")
                         for i, c in enumerate(cells)])
    return text.getvalue()


def compare(rows, tolerance, may_miss):
    lines = TARGET.read_text().splitlines()[2:]
    worst, different = 0.0, 0
    for cells, line in zip(rows, lines, strict=True):
        for name, ours, kept in zip(COLUMNS, cells, line.split(","), strict=True):
            if math.isnan(ours) and (may_miss or kept == ""):
                continue
            wanted = float(kept) if kept else math.nan
            # a probability counts by itself; another number near 0 is held against the least that
            # matters in its unit (R's noncentral pt is good to 1e-12 absolute, so its ends are less)
            floor = 0.0 if name.endswith("p") else 0.1 if name.startswith("effect") else 1e-3
            residual = abs(ours - wanted) / max(abs(wanted), floor)
            worst = max(worst, residual)
            if not residual <= tolerance:
                print(f"table {cells[0]}: {name} is {ours!r}, kept is {kept}")
                different = 1
    print(f"worst relative difference {worst:.2g}")
    return different


def main():
    if "--check-r" in sys.argv[1:]:
        if shutil.which("Rscript") is None:
            print("needs r-base-core")
            return 77
        return compare(rows_of_r(), 1e-10, may_miss=True)
    rows = [[c if isinstance(c, int) else float(c) for c in row(number)] for number in range(TABLES)]
    if "--check" in sys.argv[1:]:
        return compare(rows, 1e-11, may_miss=False)
    TARGET.write_text(written(rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
