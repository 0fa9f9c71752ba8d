#pragma once

#include <string>
#include <vector>

#include "tools/analyze/analyzed_file.h"

namespace haptometer::tools {

/// The document of `analyze --json` (docs/commands.md), indented. Unknown values are null; an error
/// becomes the only entry of `reasons`. Where a file is not answered, its band's numbers are null
/// and what was worked out all the same stands under `estimate`.
[[nodiscard]] std::string AnalysisJson(const std::vector<AnalyzedFile>& files);

}  // namespace haptometer::tools
