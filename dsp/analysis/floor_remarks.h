#pragma once

#include <vector>

#include "dsp/analysis/band_analysis.h"

/// The step of AnalyzeBand that judges the noise floor behind the numbers.
namespace haptometer::dsp {

/// Doubts of the floor behind `numbers`, of which it is the subject: the drive-off trial's own
/// refusals, another rate than the trial's `rate_hz`, a tone in it (hum, or the drive itself).
/// Nothing of a floor from the trial's own quiet part, or without one.
[[nodiscard]] std::vector<Finding> FloorDoubts(const BandNumbers& numbers, double rate_hz);

/// Says in `analysis` where the floor is missing, above what was measured (a refusal), not exceeded
/// or doubtful (FloorDoubts).
void RemarkFloor(const BandNumbers& numbers, BandAnalysis* analysis);

}  // namespace haptometer::dsp
