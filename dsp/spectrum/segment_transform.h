#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "dsp/spectrum/fft.h"

namespace haptometer::dsp {

struct WelchOptions;

/// Cuts overlapping segments out of a signal, detrends, windows and transforms them: what Welch's
/// spectra and spectrograms share. One plan, one buffer; one thread at a time.
class SegmentTransform {
 public:
  /// `options` as WelchSpectrum accepts them.
  explicit SegmentTransform(const WelchOptions& options);

  /// Segments that fit into `samples`.
  [[nodiscard]] std::size_t Count(std::size_t samples) const;

  /// The transform of segment `index` of `signal`, until the next call.
  [[nodiscard]] std::span<const std::complex<double>> Of(std::span<const double> signal,
                                                         std::size_t index);

  /// What turns |bin k|^2 into a one-sided density: c_k / (rate sum w^2), see WelchSpectrum.
  [[nodiscard]] double DensityScale(std::size_t bin) const;

  [[nodiscard]] std::size_t size() const { return window_.size(); }
  [[nodiscard]] std::size_t step() const { return step_; }
  [[nodiscard]] double rate_hz() const { return rate_hz_; }
  [[nodiscard]] const std::vector<double>& window() const { return window_; }

 private:
  double rate_hz_ = 0;
  int detrend_degree_ = 0;  // -1: nothing is taken off
  std::vector<double> window_;
  double window_square_sum_ = 0;
  std::size_t step_ = 1;
  RealFft fft_;
  std::vector<double> samples_;
  std::vector<std::complex<double>> bins_;
};

}  // namespace haptometer::dsp
