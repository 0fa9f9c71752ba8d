#pragma once

#include <string>
#include <vector>

#include "dsp/analysis/band_analysis.h"

/// The step of AnalyzeBand that judges the noise floor behind the numbers.
namespace haptometer::dsp {

/// What lets doubt the floor behind `numbers`, a sentence each: the drive-off trial's own reasons,
/// another rate than the trial's `rate_hz`, a tone in it (hum, or the drive itself). Nothing of a
/// floor from the trial's own quiet part, or without one.
[[nodiscard]] std::vector<std::string> FloorDoubts(const BandNumbers& numbers, double rate_hz);

/// Says in `analysis` where the floor is missing, above what was measured (a reason), not exceeded
/// or doubtful (FloorDoubts).
void RemarkFloor(const BandNumbers& numbers, BandAnalysis* analysis);

}  // namespace haptometer::dsp
