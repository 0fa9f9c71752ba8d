#pragma once

#include "dsp/analysis/band_analysis.h"

/// The step of AnalyzeBand that judges the noise floor behind the numbers.
namespace haptometer::dsp {

/// Says in `analysis` where the floor is missing, above what was measured (a reason), not exceeded,
/// or, of a drive-off trial, recorded at another rate, doubtful, or with a tone in it: hum, or the
/// drive itself.
void RemarkFloor(const BandNumbers& numbers, BandAnalysis* analysis);

}  // namespace haptometer::dsp
