#pragma once

#include <optional>
#include <span>
#include <vector>

#include "dsp/statistics/interval.h"

namespace haptometer::dsp {

/// How well repeats agree, against how much subjects differ.
struct Reliability {
  double icc = 0;        ///< ICC(1,1): between-subject variance / (between + within)
  Interval interval;     ///< of the population's ICC
  double within_sd = 0;  ///< of one repeat about its subject's mean, in the values' unit
};

/// One-way random effects over `cells`: the repeats of each subject, as many for each. With
/// F = MS between / MS within and k repeats
///   icc = (F - 1) / (F + k - 1),   ends the same of F / F_.975(n-1, n(k-1)) and
///   F F_.975(n(k-1), n-1)
/// (K. O. McGraw and S. P. Wong, Psychological Methods 1(1), 1996, case 1, table 7).
///
/// Nothing with fewer than 2 subjects or repeats, unequal repeats, or repeats that do not differ.
[[nodiscard]] std::optional<Reliability> AssessRepeats(std::span<const std::vector<double>> cells);

/// The coefficient of variation of exp(X), X normal with standard deviation `sd` (of a lognormal
/// value, sd / mean): sqrt(exp(sd^2) - 1).
[[nodiscard]] double VariationOfLogs(double sd);

}  // namespace haptometer::dsp
