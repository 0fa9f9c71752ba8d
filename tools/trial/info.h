#pragma once

#include <string>
#include <string_view>

#include "tools/document/document.h"
#include "trial/trial_reader.h"

namespace haptometer::tools {

/// What a recording holds: header, channels, rows, times, gaps, labels, losses. `verb` answers with
/// it; `recording` must outlive it. `has_figures`: with a figure of the first eight channels.
[[nodiscard]] document::Document TrialDocument(std::string_view verb, const std::string& path,
                                               const trial::Recording& recording, bool has_figures);

}  // namespace haptometer::tools
