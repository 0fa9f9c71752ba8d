#include "dsp/statistics/one_sample.h"

#include <cmath>

#include "dsp/statistics/distributions.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {

OneSample TestMean(std::span<const double> values) {
  OneSample sample{.n = values.size(), .mean = Mean(values)};
  if (sample.n < 2) return sample;
  sample.standard_deviation = StandardDeviation(values);
  if (!(*sample.standard_deviation > 0)) return sample;
  const auto n = static_cast<double>(sample.n);
  const double error = *sample.standard_deviation / std::sqrt(n);
  const double reach = StudentCritical(n - 1) * error;
  const double t = sample.mean / error;
  sample.test = {t, n - 1, StudentTwoSidedP(t, n - 1), {sample.mean - reach, sample.mean + reach}};
  return sample;
}

}  // namespace haptometer::dsp
