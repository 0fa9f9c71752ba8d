#pragma once

#include <span>

namespace haptometer::dsp {

/// A sine in a signal: x[n] = amplitude cos(2 pi frequency n/rate + phase) + offset + residual.
///
/// Uncertainties are standard uncertainties from the residual, which is taken as white over
/// `noise_bandwidth_hz`; NaN where converged is false.
struct SineFit {
  double frequency_hz = 0;
  double amplitude = 0;  ///< >= 0, in the signal's unit
  double phase_rad = 0;  ///< at the first sample, -pi to pi
  double offset = 0;
  double residual_rms = 0;              ///< of what the sine and offset leave
  double frequency_uncertainty_hz = 0;  ///< 0 where the frequency was given
  double amplitude_uncertainty = 0;
  double phase_uncertainty_rad = 0;
  int iterations = 0;
  bool converged = false;  ///< false: the numbers are the start's and mean nothing more
};

/// How a fit reads its signal.
struct SineFitOptions {
  double rate_hz = 0;
  /// One-sided bandwidth of the noise: rate/2 for white noise (0 means that), upper - lower corner
  /// after a band-pass. Correlated samples count for less: uncertainties grow by
  /// sqrt(rate / (2 bandwidth)).
  double noise_bandwidth_hz = 0;
};

/// Fits amplitude, phase and offset at a known frequency: linear least squares.
///
/// IEEE Std 1057-2017, 4.6.2 (three-parameter fit). Needs at least 4 samples and half a period;
/// less gives converged = false.
[[nodiscard]] SineFit FitSineAt(std::span<const double> signal, const SineFitOptions& options,
                                double frequency_hz);

/// Fits the frequency too, by Gauss-Newton from `start_hz`, which must lie within about 1/duration
/// of the truth (dsp/spectrum/tone.h finds it).
///
/// IEEE Std 1057-2017, 4.6.3 (four-parameter fit). For white noise of variance s^2 over N samples
/// and T seconds, u(amplitude)^2 = 2 s^2/N and u(2 pi frequency)^2 = 24 s^2/(amplitude^2 N T^2).
/// converged is false when the frequency leaves the start by more than 2/T or does not come to rest
/// in 30 steps. Cost: about 10 flops per sample and step; memory of one block.
[[nodiscard]] SineFit FitSine(std::span<const double> signal, const SineFitOptions& options,
                              double start_hz);

}  // namespace haptometer::dsp
