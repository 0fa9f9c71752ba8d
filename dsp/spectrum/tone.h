#pragma once

#include <optional>
#include <span>

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

}  // namespace haptometer::dsp
