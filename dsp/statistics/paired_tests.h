#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "dsp/statistics/distributions.h"
#include "dsp/statistics/moments.h"

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

/// How large a paired difference is against its spread.
struct EffectSize {
  double d_z = 0;                    ///< mean(a - b) / sd(a - b)
  double hedges_g = 0;               ///< HedgesCorrection(n - 1) d_z
  double d_av = 0;                   ///< mean(a - b) / ((sd(a) + sd(b)) / 2)
  std::optional<Interval> interval;  ///< of the population's mean difference / sd, see below
};

/// J(df) = Gamma(df/2) / (sqrt(df/2) Gamma((df-1)/2)), the exact factor that takes the bias from
/// d: 0.888203 for df = 7 (L. V. Hedges, Journal of Educational Statistics 6(2), 1981, eq. 6e).
/// df > 1.
[[nodiscard]] double HedgesCorrection(double df);

/// d_z, Hedges g and d_av (D. Lakens, Frontiers in Psychology 4:863, 2013, eqs. 7, 4 and 10).
///
/// The interval inverts noncentral t and is of the population's effect, its mean difference over
/// its standard deviation, which d_z and g both estimate; g does not lie in its middle. It is exact
/// as it is, so it is not multiplied by J (doing so would make it cover less than 95 %). d_av has
/// none here: no exact one is known. Nothing with fewer than 3 pairs, or where the differences are
/// all alike. a and b as in ComparePairs().
[[nodiscard]] std::optional<EffectSize> EffectOfPairs(std::span<const double> a,
                                                      std::span<const double> b);

inline constexpr std::size_t kMostSignFlips = 20;

/// The exact two-sided sign-flip test of paired differences: the share of all 2^n choices of signs
/// whose |sum| reaches that of the differences as they are. The least p that n differences can give
/// is 2^(1-n): 0.0078 for 8.
///
/// Sums that differ by less than 1e-12 of the sum of |differences| count as equal (they are sums of
/// the same numbers in another rounding). Valid where the differences are symmetric about 0 under
/// the null hypothesis (R. A. Fisher, The Design of Experiments, 1935, 21). Nothing for no or more
/// than 20 values. Cost: n 2^(n-1) additions, 10 ms for 20.
[[nodiscard]] std::optional<double> SignFlipP(std::span<const double> differences);

/// Holm's adjusted p values, in the order of `p`: p(k), k-th smallest of m, becomes
///   max over j <= k of min(1, (m - j + 1) p(j))
/// Rejecting those below alpha keeps the chance of any false rejection below alpha, however the
/// tests depend on each other (S. Holm, Scandinavian Journal of Statistics 6(2), 1979).
[[nodiscard]] std::vector<double> HolmAdjusted(std::span<const double> p);

/// The same over the tests that there are: nothing stays nothing, and does not count.
[[nodiscard]] std::vector<std::optional<double>> HolmOverTested(
    std::span<const std::optional<double>> p);

}  // namespace haptometer::dsp
