#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace haptometer::dsp {

/// A low-pass that takes every `factor`-th sample: means of `factor` samples, taken kOrder times
/// over (a B-spline of order 6; E. B. Hogenauer, An economical class of digital filters for
/// decimation and interpolation, IEEE ASSP-29, 1981).
///
///   |H(f)| = (sin(pi f D / rate) / (D sin(pi f / rate)))^6,   D = factor
///
/// It has no phase about the middle of its taps. What lies within f of a multiple of the new rate R
/// folds onto frequencies up to f, made smaller by (f / (R - f))^6 at least: below 1e-7 for
/// f = R / 16. For sums and fits whose band lies far below the rate.
class Decimator {
 public:
  static constexpr std::size_t kOrder = 6;

  /// `factor` >= 1 (1: the samples themselves).
  Decimator(std::size_t factor, double rate_hz);

  /// The greatest power of two that leaves a rate of `least_hz` and more, and of `size` samples
  /// `least_size` and more.
  [[nodiscard]] static std::size_t FactorFor(std::size_t size, double rate_hz, double least_hz,
                                             std::size_t least_size);

  [[nodiscard]] std::size_t factor() const { return factor_; }
  [[nodiscard]] double rate_hz() const { return rate_hz_ / static_cast<double>(factor_); }
  [[nodiscard]] std::size_t taps() const { return taps_.size(); }
  /// Samples that `size` of them leave: those whose taps all lie within.
  [[nodiscard]] std::size_t SizeOf(std::size_t size) const;
  /// |H| at a frequency below rate_hz().
  [[nodiscard]] double GainAt(double frequency_hz) const;

  /// Sample k of the result is about sample k factor + (taps() - 1) / 2 of `signal`. Cost: 6 flops
  /// a sample.
  [[nodiscard]] std::vector<double> Decimate(std::span<const double> signal) const;

 private:
  std::size_t factor_;
  double rate_hz_;
  std::vector<double> taps_;
};

}  // namespace haptometer::dsp
