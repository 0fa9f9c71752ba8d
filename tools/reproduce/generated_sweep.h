#pragma once

#include <vector>

#include "base/error.h"
#include "tools/reproduce/thesis_model.h"
#include "tools/study/linearity_result.h"

namespace haptometer::tools {

/// Readings of a drive sweep from 0 V to 5 V in steps of half a volt, from 1 V on, on the prototype
/// IA#1 (Figure 3.5): each is a simulated second under a 10 kHz sensor, analysed in the band. Two
/// subjects, whose skins are a fifth softer and stiffer than the model's.
/// Errors: as dsp::AnalyzeBand; Cause::kCannotAnswer where it does not answer.
[[nodiscard]] Result<std::vector<DriveReading>> GenerateSweep(const ThesisModel& model);

}  // namespace haptometer::tools
