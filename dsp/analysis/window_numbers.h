#pragma once

#include <vector>

#include "base/result.h"
#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/analysis/used_part.h"
#include "trial/record.h"

/// The step of AnalyzeBand that measures the window that was chosen.
namespace haptometer::dsp {

/// Fills `analysis.numbers` from `chosen`, and says in reasons and remarks what they hold.
/// `all` are all the record's signals, `displacement` their channel of the head. Errors: as
/// RowSource::Read.
[[nodiscard]] Result<void> MeasureWindow(const trial::Record& head,
                                         const trial::Channel& displacement,
                                         const std::vector<BandSignal>& all,
                                         const ChosenPart& chosen, const BandQuestion& question,
                                         BandAnalysis* analysis);

}  // namespace haptometer::dsp
