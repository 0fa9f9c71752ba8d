#pragma once

#include "dsp/analysis/band_noise.h"
#include "dsp/analysis/thinned_samples.h"
#include "dsp/spectrum/sine_fit.h"

namespace haptometer::dsp {

/// What a tone and its harmonics hold of a window's mean square, and what is left without them.
struct TonePower {
  double mean_square = 0;  ///< noise's share taken off; below 0 where that is the larger
  double variance = 0;     ///< of `mean_square`, from the noise about each line
  double density = 0;      ///< one-sided, of the noise about the tone
  NoisePower rest;         ///< of the samples
};

/// Splits `samples`, from a window of `window_s`, into `tone` with those harmonics of it in the
/// band that stand out, and the rest.
///
/// Each line is fitted beside the others (dsp/spectrum/tone.h) and taken off. With S the
/// rest's density about a line of amplitude A, noise adds S / T to the mean of A^2 / 2 and has
/// given it the variance A^2 S / T. Where the harmonics' fit does not settle, `tone` alone is taken
/// off.
[[nodiscard]] TonePower SplitTone(const ThinnedSamples& samples, const SineFit& tone,
                                  const BandPass& band, double window_s);

}  // namespace haptometer::dsp
