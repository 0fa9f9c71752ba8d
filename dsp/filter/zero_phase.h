#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dsp/filter/butterworth.h"

namespace haptometer::dsp {

/// How a signal is thought to go on beyond its ends: turned about the end point (2 x[0] - x[k]), or
/// staying at the end value.
enum class Continuation : std::uint8_t { kOdd, kConstant };

/// Samples after which the slowest pole has decayed to `remainder` (0 to 1).
[[nodiscard]] std::size_t RingingSamples(const FilterDesign& design, double remainder);

/// Filters forward, then backward: gain |H|^2, no phase.
///
/// The signal is continued at both ends by as many samples as the slowest pole needs to decay to
/// 1e-12 (where an odd continuation runs out of samples, its last value stays), and both passes
/// start exactly from their first value. What the continuation cannot know is in the first and last
/// tenths of a second: dsp/filter/settled.h finds where it ends. Returns signal.size() samples.
/// Memory: the signal and its continuation once more.
[[nodiscard]] std::vector<double> FilterZeroPhase(const FilterDesign& design,
                                                  std::span<const double> signal,
                                                  Continuation continuation = Continuation::kOdd);

}  // namespace haptometer::dsp
