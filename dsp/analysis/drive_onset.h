#pragma once

#include <optional>

#include "base/error.h"
#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/window_choice.h"
#include "trial/row_source.h"

/// The step of AnalyzeBand that finds when the drive and the vibration began.
namespace haptometer::dsp {

/// The onset of the part that `chosen` is of, of unfiltered samples (a zero-phase filter rings
/// ahead of it) from at most 1 s of the quiet part before it to at most 1 s of its steady part.
///
/// Nothing where no quiet part lies before it, or FindOnset determines none. Errors: as
/// RowSource::Read. Cost: DemodulateTone of 2 s and what lies between.
[[nodiscard]] Result<std::optional<OnsetNumbers>> FindDriveOnset(const trial::RowSource& source,
                                                                 const ChosenPart& chosen,
                                                                 double tone_hz);

}  // namespace haptometer::dsp
