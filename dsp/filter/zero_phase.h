#pragma once

#include <span>
#include <vector>

#include "dsp/filter/butterworth.h"
#include "dsp/filter/zero_phase_blocks.h"

namespace haptometer::dsp {

/// Filters forward, then backward: gain |H|^2, no phase. Returns signal.size() samples.
///
/// All blocks of ZeroPhaseBlocks, so the same signal read from a file gives the same bytes; so does
/// any number of threads. Memory: the result, and a few blocks a thread.
[[nodiscard]] std::vector<double> FilterZeroPhase(const FilterDesign& design,
                                                  std::span<const double> signal,
                                                  Continuation continuation = Continuation::kOdd,
                                                  int threads = 1);

}  // namespace haptometer::dsp
