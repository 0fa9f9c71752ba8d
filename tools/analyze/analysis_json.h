#pragma once

#include <string>
#include <vector>

#include "tools/analyze/analyzed_file.h"

namespace haptometer::tools {

/// The document of `analyze --json` (docs/commands.md), indented. Unknown values are null; an error
/// becomes the only entry of `reasons`. Where a file is not answered, RMS and amplitude are null
/// and what was worked out all the same stands under `band_rms_estimate_m` and
/// `tone_amplitude_estimate_m`.
[[nodiscard]] std::string AnalysisJson(const std::vector<AnalyzedFile>& files);

}  // namespace haptometer::tools
