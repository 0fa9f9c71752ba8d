#pragma once

#include <complex>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace haptometer::dsp {

/// cos and sin of 2 pi frequency k / rate, k = 0 .. size - 1.
struct Turns {
  std::vector<double> cosine;
  std::vector<double> sine;
};
[[nodiscard]] Turns TurnsOf(double frequency_hz, double rate_hz, std::size_t size);

/// Takes the sum a cosine + b sine out of `values` that is nearest to them, if its amplitude
/// sqrt(a^2 + b^2) is `most` at most; all are of one size. Nothing where the two cannot be told
/// apart (fewer than about a twelfth of a period).
void TakeOutNearest(const Turns& turns, std::span<double> values,
                    double most = std::numeric_limits<double>::infinity());

/// The square of the amplitude that `values` have at a frequency, by correlation.
[[nodiscard]] double SquaredAmplitude(std::span<const double> values, double rate_hz,
                                      double frequency_hz);

/// SquaredAmplitude of any stretch of values at one frequency, each at once: by running sums.
class ToneSums {
 public:
  ToneSums(std::span<const double> values, double rate_hz, double frequency_hz);
  [[nodiscard]] double SquaredAmplitudeOf(std::size_t begin, std::size_t size) const;

 private:
  std::vector<std::complex<double>> sums_;  // of the values before each place
};

}  // namespace haptometer::dsp
