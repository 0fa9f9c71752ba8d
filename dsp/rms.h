#pragma once

#include <functional>
#include <span>

namespace haptometer::dsp {

/// Sum of f(x) in blocks of 128, the blocks added in pairs: rounding grows with log(n), and the
/// result depends on the values alone. 0 for no values.
[[nodiscard]] double PairwiseSum(std::span<const double> values,
                                 double (*term)(double value, double about), double about);

/// Arithmetic mean, by two passes: the second adds the mean of what the first left. n >= 1.
[[nodiscard]] double Mean(std::span<const double> values);

/// sqrt(mean of x^2): about zero, not about the mean. n >= 1.
[[nodiscard]] double Rms(std::span<const double> values);

/// Sample standard deviation (n - 1), by two passes with the correction of Chan, Golub and LeVeque,
/// The American Statistician 37(3), 1983, eq. 1.7. n >= 2.
[[nodiscard]] double StandardDeviation(std::span<const double> values);

}  // namespace haptometer::dsp
