#pragma once

#include <cstddef>
#include <optional>

#include "base/error.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/filter/butterworth.h"

namespace haptometer::dsp {

/// A vibration whose frequency does not stay: a sweep.
struct FrequencyMove {
  double from_hz = 0;  ///< as time goes on, over the longest run of small steps
  double to_hz = 0;
};

/// Whether the strongest tone moves over samples [begin, end) of a signal, all settled.
///
/// Looked at are blocks of two periods of the lower corner, and the tone that stands out of each
/// (dsp/spectrum/tone.h). Where five unevenly spread ones agree to 1 %, it stays. Else, of at most
/// 48 blocks evenly spread (they overlap by half in a short part), it moves where at least 8 blocks
/// have one and, with the span from the 10th to the 90th percentile of their frequencies:
/// - the span is a tenth of its lower end or more;
/// - a fifth of the blocks or more lie in the span's middle 60 %: no hop from one tone to another;
/// - of the steps from block to block that are more than a hundredth of it, three quarters or more
///   are a quarter of it at most, and four fifths go on as the one before: noise goes back and
///   forth.
/// Bursts of one tone with noise between do not move, a sweep through a resonance does.
/// Errors: as BandSignal::Read. Cost: the blocks' samples; memory: one block.
[[nodiscard]] Result<std::optional<FrequencyMove>> FindFrequencyMove(const BandSignal& signal,
                                                                     std::size_t begin,
                                                                     std::size_t end,
                                                                     const BandPass& band);

}  // namespace haptometer::dsp
