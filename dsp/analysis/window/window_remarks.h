#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/analysis/window/window_choice.h"
#include "dsp/findings.h"

/// The step of AnalyzeBand that says what there is to say about a window's numbers, and the noise
/// of a drive-off trial that they may take.
namespace haptometer::dsp {

/// Adds to `analysis`, which has numbers of `chosen`, what goes with them: the filter's slope at
/// the tone, another drive than the one stated, hum, no drive, the floor, an interval wider
/// than 2.5 % to either side and the largest cause of that, segments and their ends, and motion
/// below the band.
void RemarkWindow(const std::vector<BandSignal>& all, const ChosenPart& chosen,
                  const BandQuestion& question, BandAnalysis* analysis);

/// The line with the largest standard uncertainty; a budget of no lines is a programmer's error.
[[nodiscard]] const UncertaintyLine& LargestLine(std::span<const UncertaintyLine> budget);

/// The floor that a drive-off trial gives: all of its window's power, with its rate, its strongest
/// tone and the refusals that speak against it. Nothing where it has none.
[[nodiscard]] std::optional<NoiseFloor> FloorOf(const BandAnalysis& drive_off,
                                                const std::string& source);

/// Doubts of the floor behind `numbers`, of which it is the subject: the drive-off trial's own
/// refusals, another rate than the trial's `rate_hz`, a tone in it (hum, or the drive itself).
/// Nothing of a floor from the trial's own quiet part, or without one.
[[nodiscard]] std::vector<Finding> FloorDoubts(const BandNumbers& numbers, double rate_hz);

}  // namespace haptometer::dsp
