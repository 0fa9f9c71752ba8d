#pragma once

#include <optional>

namespace haptometer::dsp {

/// From `lower` to `upper`, in the unit of what it encloses. All confidence intervals of
/// dsp/statistics are two-sided, of level 95 %.
struct Interval {
  double lower = 0;
  double upper = 0;
};

inline constexpr double kConfidence = 0.95;
/// The z with P(|Z| <= z) = `kConfidence` of a normal distribution.
inline constexpr double kNormalCritical = 1.959963984540054;

// Boost.Math behind plain functions, so that its headers stay in distributions.cc. Degrees of
// freedom are above 0 and need not be whole. Measured against SciPy, R and mpmath over the ranges
// of tests/dsp/statistics/: better than 1e-11 relative. No function throws or allocates.

/// P(|T| >= |t|) of Student's t with `df` degrees of freedom.
[[nodiscard]] double StudentTwoSidedP(double t, double df);

/// The t with P(|T| <= t) = `kConfidence`: 2.364624 for df = 7.
[[nodiscard]] double StudentCritical(double df);

/// P(F >= f) of Fisher's F with (`df1`, `df2`) degrees of freedom; f >= 0.
[[nodiscard]] double FisherUpperP(double f, double df1, double df2);

/// The f with P(F <= f) = `p`, 0 < p < 1.
[[nodiscard]] double FisherQuantile(double p, double df1, double df2);

/// The x with P(X <= x) = `p` of chi-square with `df` degrees of freedom, 0 < p < 1.
[[nodiscard]] double ChiSquareQuantile(double p, double df);

/// The noncentralities of which `t` is the upper and the lower 2.5 % point of noncentral t:
///   P(T(df, lower) >= t) = P(T(df, upper) <= t) = 0.025
/// (J. Algina and H. J. Keselman, Educational and Psychological Measurement 63(4), 2003). Nothing
/// where |t| or |t| / sqrt(df) is beyond 1e3: the distribution cannot be computed there. Cost: some
/// 30 evaluations of the distribution an end, about 0.1 ms.
[[nodiscard]] std::optional<Interval> NoncentralityInterval(double t, double df);

/// The noncentrality at which a two-sided t test of level `alpha` rejects with probability `power`,
/// alpha < power < 1:
///   P(|T(df, noncentrality)| >= t_crit(df, alpha)) = power
/// Over sqrt(n), df = n - 1, it is the mean of n paired differences in their standard deviations:
/// 1.1560 for n = 8, alpha 0.05, power 0.8. Nothing where t_crit or t_crit / sqrt(df) is beyond
/// 1e3.
[[nodiscard]] std::optional<double> NoncentralityForPower(double df, double alpha, double power);

}  // namespace haptometer::dsp
