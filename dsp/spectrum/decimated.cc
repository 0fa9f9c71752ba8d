#include "dsp/spectrum/decimated.h"

#include <array>
#include <cmath>
#include <numbers>

#include "base/error.h"

namespace haptometer::dsp {
namespace {

// sum of products; eight running sums do not depend on each other, so they overlap
double Dot(const double* x, std::span<const double> taps) {
  constexpr std::size_t kLanes = 8;
  std::array<double, kLanes> sums{};
  std::size_t k = 0;
  for (; k + kLanes <= taps.size(); k += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) sums[lane] += x[k + lane] * taps[k + lane];
  }
  for (; k < taps.size(); ++k) sums[k % kLanes] += x[k] * taps[k];
  return ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
}

}  // namespace

Decimator::Decimator(std::size_t factor, double rate_hz)
    : factor_(factor), rate_hz_(rate_hz), taps_{1.0} {
  HAPTOMETER_CHECK(factor >= 1 && rate_hz > 0, "factor {}, rate_hz = {}", factor, rate_hz);
  // kOrder convolutions with a mean of `factor` samples
  for (std::size_t order = 0; order < kOrder; ++order) {
    std::vector<double> longer(taps_.size() + factor - 1);
    for (std::size_t k = 0; k < taps_.size(); ++k) {
      for (std::size_t n = 0; n < factor; ++n) {
        longer[k + n] += taps_[k] / static_cast<double>(factor);
      }
    }
    taps_ = std::move(longer);
  }
}

std::size_t Decimator::FactorFor(std::size_t size, double rate_hz, double least_hz,
                                 std::size_t least_size) {
  std::size_t factor = 1;
  while (rate_hz / static_cast<double>(2 * factor) >= least_hz &&
         size / (2 * factor) >= least_size) {
    factor *= 2;
  }
  return factor;
}

std::size_t Decimator::SizeOf(std::size_t size) const {
  return size < taps_.size() ? 0 : (size - taps_.size()) / factor_ + 1;
}

double Decimator::GainAt(double frequency_hz) const {
  const double turn = std::numbers::pi * frequency_hz / rate_hz_;
  if (turn == 0) return 1;
  // (sin(pi f D / rate) / (D sin(pi f / rate)))^6; the limit at f = 0 is 1
  const auto factor = static_cast<double>(factor_);
  return std::pow(std::sin(turn * factor) / (factor * std::sin(turn)), static_cast<double>(kOrder));
}

std::vector<double> Decimator::Decimate(std::span<const double> signal) const {
  std::vector<double> decimated(SizeOf(signal.size()));
  for (std::size_t k = 0; k < decimated.size(); ++k) {
    decimated[k] = Dot(&signal[k * factor_], taps_);
  }
  return decimated;
}

}  // namespace haptometer::dsp
