#pragma once

#include "base/error.h"
#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/band_filtering.h"

/// The step of AnalyzeBand for records that are too slow for the band.
namespace haptometer::dsp {

/// Fits a tone whose frequency f is known (the question's, or the file's drive) to the readings,
/// with a straight line beside it, where a reading's time is known to 0.1 / f (one standard
/// deviation, of every stretch) or by itself (Record::times_are_known); never to a polled sensor's
/// readings, which are of unknown age.
///
/// Above half the rate of new readings the tone is seen as an alias: other motion at the alias is
/// then taken for it, and a note says so. At a multiple of the rate, where all readings see one
/// phase, nothing is fitted. Reads 2^21 rows at most. Errors: as RowSource::Read.
[[nodiscard]] Result<void> FitKnownTone(const Displacement& displacement,
                                        const BandQuestion& question, BandAnalysis* analysis);

}  // namespace haptometer::dsp
