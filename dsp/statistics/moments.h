#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "dsp/statistics/distributions.h"

namespace haptometer::dsp {

// All sums run over blocks of 128 values, and the blocks are added in pairs: rounding grows with
// log(n), and the result depends on the values alone. Cost: one or two passes; no allocation.

/// Arithmetic mean: the mean, then the mean of what it leaves. At least 1 value.
[[nodiscard]] double Mean(std::span<const double> values);

/// sqrt(mean of x^2): about zero, not about the mean. At least 1 value.
[[nodiscard]] double Rms(std::span<const double> values);

/// Sample standard deviation (n - 1): two passes with the correction of Chan, Golub and LeVeque,
/// The American Statistician 37(3), 1983, eq. 1.7. At least 2 values.
///
/// On the NIST sets NumAcc1-4 it is within half a digit of exact arithmetic on the stored doubles.
[[nodiscard]] double StandardDeviation(std::span<const double> values);

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
