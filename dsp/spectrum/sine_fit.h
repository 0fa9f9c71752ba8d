#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace haptometer::dsp {

/// cos(w t) and sin(w t) over blocks of evenly spaced t, for the sums of sine fits and of
/// demodulation.
///
/// Each block begins with the library's own sine and cosine and is turned from there by a table, so
/// that an error never grows with the record: below 3e-16 beyond the rounding of w t itself.
class PhasorBlocks {
 public:
  /// The most samples of a block.
  static constexpr std::size_t kBlock = 256;

  /// `rad_per_sample` is w times the samples' spacing.
  explicit PhasorBlocks(double rad_per_sample);

  /// cos(w t), sin(w t) for t = first, first + 1, ... samples; both spans have one size, at most
  /// kBlock.
  void Fill(double first, std::span<double> cosines, std::span<double> sines) const;

 private:
  double rad_per_sample_ = 0;
  std::array<double, kBlock> cosines_{};
  std::array<double, kBlock> sines_{};
};

/// Subtracts cosine cos(w n) + sine sin(w n) from `samples`, n = first, first + 1 ..., w =
/// `rad_per_sample`. Cost: 6 flops a sample.
void SubtractSine(double rad_per_sample, double cosine, double sine, double first,
                  std::span<double> samples);

/// A sine in a signal, with the drift it rides on:
///
///   x(t) = amplitude cos(2 pi frequency t + phase) + drift(t) + residual,   t = n / rate
///
/// Uncertainties are standard uncertainties from the residual, which is taken as white over
/// `noise_bandwidth_hz`; NaN where converged is false. For a 95 % interval multiply them by the t
/// quantile of `degrees_of_freedom`.
struct SineFit {
  double frequency_hz = 0;
  double amplitude = 0;     ///< >= 0, in the signal's unit
  double phase_rad = 0;     ///< at the first sample (FitSineAtTimes: at t = 0), -pi to pi
  double offset = 0;        ///< the drift's mean over the signal
  double residual_rms = 0;  ///< of what the sine and the drift leave
  double frequency_uncertainty_hz = 0;  ///< 0 where the frequency was given
  double amplitude_uncertainty = 0;
  double phase_uncertainty_rad = 0;  ///< NaN for an amplitude of 0
  double degrees_of_freedom = 0;     ///< independent samples less the parameters
  bool converged = false;            ///< false: the numbers are the start's and mean nothing more
};

inline constexpr int kHighestDriftDegree = 3;

/// How a fit reads its signal.
struct SineFitOptions {
  double rate_hz = 0;
  /// One-sided bandwidth of the noise: rate/2 for white noise (0 means that), upper - lower corner
  /// after a band-pass. Correlated samples count for less: uncertainties grow by
  /// sqrt(rate / (2 bandwidth)).
  double noise_bandwidth_hz = 0;
  /// Degree of the drift, a sum of Legendre polynomials over the signal fitted along with the sine:
  /// 0 an offset, 1 a slope too, at most kHighestDriftDegree. Motion far below the tone is so left
  /// out without a filter, and without a filter's settling.
  int drift_degree = 0;
};

/// Fits amplitude, phase and drift at a known frequency: linear least squares.
///
/// IEEE Std 1057-2017, 4.6.2 (three-parameter fit); with a slope it is the mixed model. For white
/// noise of variance s^2 over N samples, u(amplitude)^2 = 2 s^2/N (Cramer and Rao's bound, which a
/// linear fit reaches). Needs half a period, more independent samples than parameters, and a
/// frequency below rate/2; less, values that are not finite, or columns that cannot be told apart
/// (condition above 1e10) give converged = false.
[[nodiscard]] SineFit FitSineAt(std::span<const double> signal, const SineFitOptions& options,
                                double frequency_hz);

/// FitSineAt for samples taken at any times: `times_s` holds one time per value, in any order.
///
/// The frequency may lie above half the mean rate: what a polled sensor sees of a drive whose
/// frequency is known. Times that see one phase only (equal spacing of whole periods) do not
/// converge. Noise is taken as independent between samples. An uncertainty u of each time takes
/// (2 pi f u)^2 / 2 of the amplitude away, which the caller must keep small (u below 0.1 / f).
[[nodiscard]] SineFit FitSineAtTimes(std::span<const double> values,
                                     std::span<const double> times_s, double frequency_hz,
                                     int drift_degree = 0);

/// Fits the frequency too, step by step from `start_hz`, which must lie within about 1/duration of
/// the truth (dsp/spectrum/tone.h finds it).
///
/// IEEE Std 1057-2017, 4.6.3 (four-parameter fit), with Newton's steps where they lead downhill and
/// Gauss and Newton's elsewhere; a step that leaves more behind than before is halved. So a tone
/// that decays, where the residual is large, comes to rest too: at the sine nearest to it. For
/// white noise of variance s^2 over N samples and T seconds, u(amplitude)^2 = 2 s^2/N and u(2 pi
/// frequency)^2 = 24 s^2/(amplitude^2 N T^2); the phase at the middle has 2 s^2/(amplitude^2 N), at
/// the first sample four times that. converged is false when the frequency leaves the start by more
/// than 2/T or does not come to rest in 30 steps (rest: it moves the phase at the ends by less than
/// 1e-10 rad or 1e-3 of its uncertainty). Cost: about 15 flops per sample and step; memory: one
/// copy of the signal.
[[nodiscard]] SineFit FitSine(std::span<const double> signal, const SineFitOptions& options,
                              double start_hz);

}  // namespace haptometer::dsp
