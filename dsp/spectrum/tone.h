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
};

/// The strongest tone between `lower_hz` and `upper_hz`: the largest peak of a Hann-windowed FFT
/// (FFTW), interpolated, then fitted by FitSine.
///
/// Nothing where the fit does not converge within the band (half a bin of slack at its ends), where
/// fewer than two periods of lower_hz or more than 2^30 samples were given, or where the tone does
/// not stand out: noise alone must give so high a peak with a probability below 1e-3
/// (amplitude^2 / (2 u^2) > ln(1000 x bins in the band)).
/// Threads may call it; FFTW's planner is guarded. Memory: two copies of the signal.
[[nodiscard]] std::optional<SineFit> StrongestTone(std::span<const double> signal,
                                                   const ToneSearch& search);

}  // namespace haptometer::dsp
