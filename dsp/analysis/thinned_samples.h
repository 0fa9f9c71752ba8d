#pragma once

#include <vector>

#include "dsp/analysis/band_noise.h"

namespace haptometer::dsp {

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
/// samples.
[[nodiscard]] ThinnedSamples Thinned(std::vector<double> filtered, double rate_hz,
                                     const FilterDesign& design, const BandPass& band);

}  // namespace haptometer::dsp
