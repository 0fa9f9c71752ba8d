#pragma once

#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/band_filtering.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/analysis/window/window_choice.h"

/// The step of AnalyzeBand that measures the window that was chosen.
namespace haptometer::dsp {

/// Fills `analysis.numbers` from `chosen`, and says in its findings what they hold.
/// `all` are all the record's signals. Errors: as RowSource::Read.
[[nodiscard]] Result<void> MeasureWindow(const Displacement& displacement,
                                         const std::vector<BandSignal>& all,
                                         const ChosenPart& chosen, const BandQuestion& question,
                                         BandAnalysis* analysis);

}  // namespace haptometer::dsp
