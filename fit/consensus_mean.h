#pragma once

#include <vector>

namespace haptometer::fit {

/// A result of one recording and the variance that its own noise gives it.
struct Estimate {
  double value = 0;
  double variance = 0;  ///< >= 0
};

/// The common value of several estimates that may scatter by more than their noise.
struct ConsensusMean {
  double value = 0;
  double variance = 0;
  double scatter_variance = 0;  ///< the part of it that the estimates' scatter added
  double between_variance = 0;  ///< t^2 below, of one estimate; 0: their noise explains them
  /// Root of the mean square of the deviations from the mean of weights 1/u^2, in units of u
  /// (R. T. Birge, Phys. Rev. 40, 207 (1932)); 0: one estimate.
  double birge_ratio = 0;
};

/// The weighted mean whose weights contain a variance t^2 between the estimates,
///
///     m = sum(w x)/sum(w),   w = 1/(u^2 + t^2),   variance 1/sum(w),
///
/// t^2 being 0 where the noise explains the scatter, F(0) <= n - 1, else the root of
///
///     F(t^2) = sum(w (x - m)^2) = n - 1
///
/// (R. C. Paule and J. Mandel, J. Res. NBS 87 (1982) 377-385). There Hartung and Knapp's variance
/// sum(w (x - m)^2)/((n - 1) sum(w)) (Stat. Med. 20 (2001) 3875-3889) is the same number. Estimates
/// of equal u have the variance of 1/u^2 widened by the Birge ratio. Where the scatter dominates,
/// all weigh alike: a strong tap shows its own constant well, not that of the others.
///
/// With ScatterCoverage (fit/uncertainty.h) of scatter_variance and n - 1, 93 to 97 of 100
/// intervals hold for 2 to 6 estimates where the scatter between them is 0 or beyond 50 times the
/// largest u, for u alike or up to 1:8 (tests/fit/consensus_mean_test.cc). In between they hold
/// less: two estimates hardly show a scatter near u (84 % of alike ones at 4 u, four of them 92 %).
///
/// Cost: some ten passes. At least one estimate.
[[nodiscard]] ConsensusMean ConsensusOf(const std::vector<Estimate>& estimates);

/// F(t^2) of several groups, each with its own mean: the sum of the groups'.
[[nodiscard]] double SquaresOf(const std::vector<std::vector<Estimate>>& groups,
                               double between_variance);

/// The t^2 >= 0 at which F of the groups has fallen to `squares` > 0, to 1e-12 of these; 0 where it
/// is not larger. No group is empty.
[[nodiscard]] double BetweenVariance(const std::vector<std::vector<Estimate>>& groups,
                                     double squares);

/// F for a t^2 whose normal interval is Student's. For n estimates of equal u, or of a large
/// scatter, the n - 1 degrees of freedom give
///
///     1.96^2/sum(w) = t(n - 1)^2 s^2/n   at   F(t^2) = (n - 1) (1.96/t(n - 1))^2,
///
/// s being their empirical standard deviation and t(n - 1) Student's factor: +-1.96/sqrt(sum(w))
/// about ConsensusOf's value is the interval of few values that scatter, and never below that of
/// their noise. It holds the common value in 93 to 99 of 100 sets for any scatter, of 2 to 6
/// estimates of u alike or up to 1:8. No interval of constant coverage exists there: a strong
/// estimate's own scatter shows only beside the noise of the weak ones, so that what holds it must
/// be too wide where there is none.
///
/// @param degrees n - 1, >= 1
[[nodiscard]] double StudentSquares(double degrees);

}  // namespace haptometer::fit
