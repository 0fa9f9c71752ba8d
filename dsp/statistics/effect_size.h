#pragma once

#include <optional>
#include <span>

#include "dsp/statistics/interval.h"

namespace haptometer::dsp {

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
/// all alike. a and b as in paired.h.
[[nodiscard]] std::optional<EffectSize> EffectOfPairs(std::span<const double> a,
                                                      std::span<const double> b);

}  // namespace haptometer::dsp
