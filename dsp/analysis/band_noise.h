#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "dsp/filter/butterworth.h"
#include "dsp/spectrum/sine_fit.h"

namespace haptometer::dsp {

/// A mean square that noise made, and how far it scatters.
struct NoisePower {
  double mean_square = 0;
  double variance = 0;  ///< of `mean_square`

  /// Degrees of freedom of the chi-squared with this mean and variance; infinite without variance.
  [[nodiscard]] double degrees_of_freedom() const;
};

/// Noise over a window, by its periodogram.
///
/// With p[k] the mean square in bin k (sum over k of p = mean square of the samples without their
/// mean), Gaussian noise of any spectrum S has
///   variance of the mean square = integral of S^2 df / T = sum over k of p[k]^2 / 2
/// because E[p^2] = 2 (S/T)^2: no shape of the spectrum is assumed. The equivalent bandwidth is
/// (integral of S)^2 / integral of S^2. Bendat and Piersol, Random Data, 4th ed., 8.2.
struct BandNoise {
  NoisePower power;
  double bin_hz = 0;
  std::vector<double> bins;  ///< p[k], k from 0

  /// One-sided density about `frequency_hz`, in units^2/Hz: the mean of 24 bins on either side that
  /// lie between `lower_hz` and `upper_hz`, the nearest `left_out` (1 or more) on each side
  /// excluded and the one at it (a fit has taken its share from them). 0 where there are none.
  [[nodiscard]] double DensityNear(double frequency_hz, double lower_hz, double upper_hz,
                                   std::ptrdiff_t left_out = 1) const;
};

/// The frequency to which noise behind a band's filter is looked at: beyond 1.5 times the upper
/// corner the default filter leaves 2e-4 of its power in both passes.
[[nodiscard]] constexpr double NoiseReachHz(const BandPass& band) { return 1.5 * band.upper_hz; }

/// Measures `samples` (2 at least) taken at `rate_hz`; the bins, up to `upper_hz`, are those of
/// the samples that transform fast. Cost: one transform; memory three times the samples.
[[nodiscard]] BandNoise MeasureNoise(std::span<const double> samples, double rate_hz,
                                     double upper_hz);

/// Blackman and Harris's window of four terms at `count` samples, about their middles: side lobes
/// below -92 dB (F. J. Harris, Proc. IEEE 66, 1978, p. 51).
[[nodiscard]] std::vector<double> BlackmanHarris(std::size_t count);

/// Frequencies that noise is not looked for in.
struct FrequencyRange {
  double from_hz = 0;
  double to_hz = 0;
};

/// Noise beside lines, by the median of a tapered periodogram in parts of the band.
struct NoiseBeside {
  bool is_known = false;  ///< some part has bins enough for its median
  NoisePower power;
  /// Var(sum of the bins - this estimate): what is left of the window's own noise, m4.
  double variance_of_rest = 0;
  double below_mean_square = 0;  ///< of `power`: beyond noise below the lower corner, as of tremor
  double foot_mean_square = 0;   ///< beyond noise in the lowest part: tremor, or vibration
  double least_density = 0;      ///< of the quietest part, 3.29 deviations up, units^2/Hz
  /// The median of the parts in the band's upper half, one standard uncertainty down, units^2/Hz.
  double upper_density = 0;
  double flat_mean_square = 0;  ///< of noise that is as dense everywhere
  std::vector<FrequencyRange> parts;
  std::vector<double> densities;  ///< one-sided, of each part before the filter, units^2/Hz

  [[nodiscard]] double DensityAt(double frequency_hz) const;
};

/// Measures what `samples`, behind the two passes of `design`, hold of noise outside of `excluded`.
///
/// The spectrum (of BlackmanHarris) between the corners is cut into parts of 128 bins and 16 Hz at
/// least, up to a ratio of 1.5. A part's density is the median of its bins, each divided by the
/// filter's gain, over what the median is of exponential ones (a periodogram's of noise), so lines
/// and bursts that fill less than half of it change little; a part without eight bins takes its
/// neighbour's. The power is the sum of density x what the filter passes of the part, its skirts
/// included, and of what lies below the corner. Of n bins, c = 2 of which the window correlates,
/// var(median / ln 2) = 2.08 c / n of its square, and var(sum of the window's own bins, untapered,
/// - estimate) = (2.08 c - 1) / n: the mean is efficient, so that its covariance with the median is
/// its own variance. Zero where no part has bins.
[[nodiscard]] NoiseBeside MeasureNoiseBeside(std::span<const double> samples, double rate_hz,
                                             const FilterDesign& design, const BandPass& band,
                                             std::span<const FrequencyRange> excluded);

/// The power beyond noise of `rest`, what a tone and its harmonics leave (untapered): the sum over
/// the band's bins in `drive`, and those of lines anywhere, less noise of the density beside them.
/// var = (1 + 2.08 c w / 128) sum of the squares of their noise, w the bins of a range.
[[nodiscard]] NoisePower BeyondNoise(const BandNoise& rest, const NoiseBeside& beside,
                                     const FilterDesign& design, const BandPass& band,
                                     std::span<const FrequencyRange> drive);

/// The mean square over windows of unequal length, weighted by it. Empty: all 0.
struct WeightedPower {
  NoisePower power;
  double duration_s = 0;
};
[[nodiscard]] NoisePower Pooled(std::span<const WeightedPower> windows);

/// Filtered samples, as few of them as hold the band.
struct ThinnedSamples {
  std::vector<double> values_m;
  double rate_hz = 0;  ///< of `values_m`

  [[nodiscard]] double duration_s() const { return static_cast<double>(values_m.size()) / rate_hz; }
};

/// Of `filtered` at `rate_hz`, behind the two passes of `design`, every n-th.
///
/// n is the highest power of two by which at least five times the upper corner is left and what
/// folds to NoiseReachHz or below is 1e-9 of what was there before the filter, and at least 2^12
/// samples. As many are kept as transform fast, from the first on (FastTransformSize).
[[nodiscard]] ThinnedSamples Thinned(std::vector<double> filtered, double rate_hz,
                                     const FilterDesign& design, const BandPass& band);

/// What a tone and its harmonics hold of a window's mean square, and what is left without them.
struct TonePower {
  double mean_square = 0;  ///< noise's share taken off; below 0 where that is the larger
  double variance = 0;     ///< of `mean_square`, from the noise about each line
  double density = 0;      ///< one-sided, of the noise about the tone, beyond a drive's sidebands
  BandNoise rest;          ///< of the samples
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
