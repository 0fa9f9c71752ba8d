#include "dsp/statistics/effect_size.h"

#include <cmath>

#include "base/error.h"
#include "dsp/statistics/distributions.h"
#include "dsp/statistics/moments.h"
#include "dsp/statistics/paired.h"

namespace haptometer::dsp {

double HedgesCorrection(double df) {
  HAPTOMETER_CHECK(df > 1, "{} degrees of freedom", df);
  return std::exp(std::lgamma(df / 2) - std::lgamma((df - 1) / 2)) / std::sqrt(df / 2);
}

std::optional<EffectSize> EffectOfPairs(std::span<const double> a, std::span<const double> b) {
  const OneSample difference = ComparePairs(a, b);
  if (difference.n < 3 || !difference.test) return std::nullopt;
  EffectSize effect;
  effect.d_z = difference.mean / *difference.standard_deviation;
  effect.hedges_g = HedgesCorrection(difference.test->df) * effect.d_z;
  effect.d_av = difference.mean / ((StandardDeviation(a) + StandardDeviation(b)) / 2);
  if (const auto delta = NoncentralityInterval(difference.test->t, difference.test->df)) {
    const double root = std::sqrt(static_cast<double>(difference.n));
    effect.interval = Interval{delta->lower / root, delta->upper / root};
  }
  return effect;
}

}  // namespace haptometer::dsp
