#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace haptometer::dsp {

/// What samples at their extreme say of a limit of the sensor or its converter.
enum class ClippingVerdict : std::uint8_t {
  kNone,
  kUndecided,  ///< clipped, or harmonics: the sampled phases cannot tell
  kClipped,
};

/// Whether samples are clipped, and which.
struct Clipping {
  ClippingVerdict verdict = ClippingVerdict::kNone;
  double share = 0;                  ///< of the measured samples, at a rail; 0 for kNone
  std::optional<double> low_rail{};  ///< in the samples' unit
  std::optional<double> high_rail{};
};

/// Whether a tone is clipped, from `samples` before any filter (NaN where there is no measurement)
/// at `rate_hz`, with the tone at `tone_hz`.
///
/// Equal samples at an extreme are no proof: of a clean tone of 400 Hz at 2 kHz 19 % may be its
/// maximum. So the tone, its harmonics up to the third where they explain the samples better, and a
/// quartic drift are fitted to the samples off the rails, in blocks of 0.1 s. Clipped: at the
/// railed samples they lie beyond the rail by more than four standard deviations of what the fit
/// leaves, and of the fit there. Undecided: the sampled phases (as where rate and tone are
/// commensurate) do not determine the harmonics, so that what flattens the tone may be its own.
/// None also where one sine fits all samples as well, and where less than 0.1 % are at a rail.
///
/// False alarms, misses and what is undecided are counted in tests/dsp/analysis/clipping_test.cc.
/// Not found: rails that noise or an interpolation has blurred. Cost: one look at the samples; of
/// those with a rail 300 flops each.
[[nodiscard]] Clipping FindClipping(std::span<const double> samples, double rate_hz,
                                    double tone_hz);

}  // namespace haptometer::dsp
