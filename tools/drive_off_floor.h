#pragma once

#include <string>

#include "base/error.h"
#include "dsp/analysis/band_question.h"
#include "trial/import/import_options.h"

namespace haptometer::tools {

/// The noise floor that a drive-off trial gives in the band of `question`: all that has settled of
/// it, filtered as the trials are. `threads` changes no number.
/// Errors: as trial::OpenRows and dsp::AnalyzeBand; Cause::kCannotAnswer where it tells no floor,
/// being too slow or too short for the band.
[[nodiscard]] Result<dsp::NoiseFloor> ReadFloor(const std::string& path,
                                                const dsp::BandQuestion& question,
                                                const trial::ImportOptions& import, int threads);

}  // namespace haptometer::tools
