#include "dsp/analysis/thinned_samples.h"

#include <complex>
#include <cstddef>
#include <utility>

namespace haptometer::dsp {

ThinnedSamples Thinned(std::vector<double> filtered, double rate_hz, const FilterDesign& design,
                       const BandPass& band) {
  constexpr double kFolded = 1e-9;
  constexpr std::size_t kLeastSamples = std::size_t{1} << 12U;
  constexpr double kRatePerUpper = 5;
  std::size_t every = 1;
  const auto rate_of = [&](std::size_t n) { return rate_hz / static_cast<double>(n); };
  while (filtered.size() / (2 * every) >= kLeastSamples &&
         rate_of(2 * every) >= kRatePerUpper * band.upper_hz &&
         std::norm(Response(design, rate_of(2 * every) - NoiseReachHz(band))) <= kFolded) {
    every *= 2;
  }
  const std::size_t kept = (filtered.size() + every - 1) / every;
  for (std::size_t k = 0; k < kept; ++k) filtered[k] = filtered[k * every];
  filtered.resize(kept);
  return {std::move(filtered), rate_of(every)};
}

}  // namespace haptometer::dsp
