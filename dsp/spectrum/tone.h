#pragma once

#include <optional>
#include <span>
#include <vector>

#include "dsp/spectrum/sine_fit.h"

namespace haptometer::dsp {

/// Where to look for a tone.
struct ToneSearch {
  double rate_hz = 0;
  double lower_hz = 0;
  double upper_hz = 0;
  double noise_bandwidth_hz = 0;  ///< see SineFitOptions
  /// Probability that noise alone passes for a tone, in (0, 1).
  double false_alarm = 1e-3;
};

/// The strongest tone between `lower_hz` and `upper_hz`: the largest peak of a Hann-windowed FFT
/// (FFTW), interpolated, then fitted by FitSine.
///
/// Nothing where the fit does not converge within the band (half a bin of slack at its ends), where
/// fewer than two periods of lower_hz or more than 2^30 samples were given, or where the tone does
/// not stand out. It must stand out of the spectrum beside it: out of the noisier of its two sides,
/// each judged by the median of up to 64 bins, so that neither other tones and bursts nor the
/// tone's own decay or slow change hide it, and noise that falls with frequency does not pass for
/// one. White noise passes with less than `false_alarm` (a sixth of it at 0.05, tests); noise whose
/// power falls faster than 1/f across 64 bins may do so more often. With fewer than 16 bins on
/// either side what the fit leaves is asked instead: amplitude^2 / (2 u^2) > ln(bins in the band /
/// false_alarm). Threads may call it. Memory: three copies of the signal.
[[nodiscard]] std::optional<SineFit> StrongestTone(std::span<const double> signal,
                                                   const ToneSearch& search);

/// One multiple of the fundamental: amplitude cos(2 pi order fundamental t + phase).
struct Harmonic {
  int order = 1;  ///< 1: the fundamental itself
  double frequency_hz = 0;
  double amplitude = 0;  ///< >= 0, in the signal's unit; of noise alone about 1.25 uncertainties
  double amplitude_uncertainty = 0;
  double phase_rad = 0;  ///< at the first sample, -pi to pi
  double phase_uncertainty_rad = 0;
  bool stands_out = false;  ///< noise alone gives such an amplitude once in a hundred times
};

/// What FitHarmonics finds.
///
///   THD = sqrt(sum over h >= 2 of a_h^2) / a_1
///
/// with a^2 = amplitude^2 - 2 u^2: the power that noise adds to each is taken off. Between `least`
/// and the limit that the caller gave; a harmonic above it counts for nothing.
struct Harmonics {
  std::vector<Harmonic> harmonics;  ///< from order 1 up
  /// Nothing ("not determined") where the harmonics together do not stand out of the noise (1 %
  /// false alarms), or where there is none below the limit.
  std::optional<double> thd;
  double thd_uncertainty = 0;         ///< standard uncertainty, where thd is determined
  std::optional<double> thd_at_most;  ///< one-sided 95 % bound, where there is a harmonic
  double residual_rms = 0;            ///< of what all of them and the drift leave
  double degrees_of_freedom = 0;      ///< independent samples less the parameters
  bool converged = false;             ///< false: nothing else is set
};

/// The most harmonics of one fit, the fundamental included.
inline constexpr int kMostHarmonics = 64;

/// Fits the fundamental and its multiples up to `upper_hz` (and below rate/2) together, beside the
/// drift of `options`, by linear least squares: no bins, any length, no window.
///
/// The fundamental is taken as exact (FitSine finds it): an error d of it turns the h-th multiple
/// by pi h d duration at the ends, which takes a sixth of that squared from its amplitude. White
/// noise of variance s^2 gives each amplitude the uncertainty s sqrt(2/N) (Cramer and Rao's bound).
/// Needs a period of the fundamental and more independent samples than parameters; less gives
/// converged = false. Cost: (2 h)^2 flops per sample for h harmonics; memory: one copy of the
/// signal. IEEE Std 1057-2017, 4.4.1.2 (THD from least-squares fits); the noise's share is our own.
[[nodiscard]] Harmonics FitHarmonics(std::span<const double> signal, const SineFitOptions& options,
                                     double fundamental_hz, double upper_hz);

}  // namespace haptometer::dsp
