#pragma once

#include <optional>
#include <span>

#include "dsp/statistics/interval.h"
#include "dsp/statistics/one_sample.h"

namespace haptometer::dsp {

// Two conditions measured on the same units (subjects): a[i] and b[i] belong together. Both spans
// are of one length, at least 1. The pairs must be independent: one pair a subject, never a trial.

/// Student's paired t: TestMean of a[i] - b[i].
[[nodiscard]] OneSample ComparePairs(std::span<const double> a, std::span<const double> b);

/// The geometric mean of a[i] / b[i], tested against 1.
struct GeometricRatio {
  double ratio = 0;
  OneSample log_ratio;               ///< of ln(a[i] / b[i]): its t and p are the ratio's
  std::optional<Interval> interval;  ///< exp of the interval of the mean log ratio
};

/// exp(mean(ln a - ln b)), with the interval of the paired t on logarithms. Nothing where a value
/// is not above 0.
[[nodiscard]] std::optional<GeometricRatio> RatioOfPairs(std::span<const double> a,
                                                         std::span<const double> b);

/// The ratio of the means of paired values, by Fieller's theorem.
struct RatioOfMeans {
  double ratio = 0;  ///< mean(a) / mean(b)
  /// Nothing: unbounded. The denominator's mean cannot be told from 0 at 95 %, so no finite
  /// interval holds the ratio.
  std::optional<Interval> interval;
};

/// The rho for which mean(a) - rho mean(b) does not differ from 0 at 5 % by the paired t: the roots
/// of
///   (mb^2 - c vb) rho^2 - 2 (ma mb - c cab) rho + (ma^2 - c va) = 0,   c = t_crit^2 / n
/// with variances va, vb and covariance cab (n - 1) (E. C. Fieller, Journal of the Royal
/// Statistical Society B 16(2), 1954). Nothing with fewer than 2 pairs or mean(b) = 0.
[[nodiscard]] std::optional<RatioOfMeans> CompareMeans(std::span<const double> a,
                                                       std::span<const double> b);

}  // namespace haptometer::dsp
