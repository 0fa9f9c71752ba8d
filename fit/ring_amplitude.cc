#include "fit/ring_amplitude.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>

namespace haptometer::fit {
namespace {

using Complex = std::complex<double>;

// e^(-2 pi j n / period) as a product of two from tables: 64 first ones, and every 64th
class Turn {
 public:
  Turn(std::size_t count, double period_samples) {
    const auto at = [period_samples](std::size_t n) {
      return std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(n) / period_samples);
    };
    for (std::size_t n = 0; n < kFirst; ++n) first_.push_back(at(n));
    for (std::size_t n = 0; n <= count / kFirst; ++n) further_.push_back(at(n * kFirst));
  }

  [[nodiscard]] Complex At(std::size_t n) const {
    return further_[n / kFirst] * first_[n % kFirst];
  }

 private:
  static constexpr std::size_t kFirst = 64;
  std::vector<Complex> first_;
  std::vector<Complex> further_;
};

}  // namespace

std::vector<double> Filled(const std::vector<double>& values) {
  std::vector<double> filled = values;
  std::size_t last = values.size();
  for (std::size_t n = 0; n < values.size(); ++n) {
    if (!std::isfinite(values[n])) continue;
    const double from = last == values.size() ? values[n] : values[last];
    const std::size_t first = last == values.size() ? 0 : last + 1;
    for (std::size_t k = first; k < n; ++k) {
      filled[k] = from + (values[n] - from) * static_cast<double>(k + 1 - first) /
                             static_cast<double>(n + 1 - first);
    }
    last = n;
  }
  for (std::size_t k = last + 1; k < values.size(); ++k) filled[k] = values[last];
  return filled;
}

std::vector<double> FollowingAmplitude(const std::vector<double>& values, double middle_v,
                                       double period_samples) {
  const auto period = static_cast<std::size_t>(std::ceil(period_samples));
  const Turn turn(values.size(), period_samples);
  std::vector<Complex> turned(values.size() + 1);
  for (std::size_t n = 0; n < values.size(); ++n) {
    turned[n + 1] = turned[n] + (values[n] - middle_v) * turn.At(n);
  }
  std::vector<double> amplitudes;
  amplitudes.reserve(values.size());
  for (std::size_t n = 0; n + period < turned.size(); ++n) {
    amplitudes.push_back(std::abs(turned[n + period] - turned[n]));
  }
  return amplitudes;
}

}  // namespace haptometer::fit
