#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "dsp/statistics/interval.h"

namespace haptometer::dsp {

/// Student's t test of one mean against 0.
struct StudentTest {
  double t = 0;
  double df = 0;  ///< n - 1
  double p = 0;   ///< two-sided, exact for normal values
  Interval mean;  ///< of the population's mean, in the values' unit
};

/// Independent values: their mean, and whether it differs from 0.
struct OneSample {
  std::size_t n = 0;
  double mean = 0;
  std::optional<double> standard_deviation = {};  ///< n - 1; from 2 values
  std::optional<StudentTest> test = {};           ///< from 2 values that are not all alike
};

/// t = mean / (s / sqrt(n)); interval mean +- t_crit s / sqrt(n). At least 1 value.
[[nodiscard]] OneSample TestMean(std::span<const double> values);

}  // namespace haptometer::dsp
