#pragma once

#include <string>

#include "tools/analyze/analyze.h"
#include "tools/document/document.h"

namespace haptometer::tools {

/// The document of `count` trials before any is analysed; the first of them is `first`.
[[nodiscard]] document::Document AnalysisDocument(const std::string& first, std::size_t count);

/// What is known of one trial (docs/reference/analyze.md). Where the question is not answered, RMS
/// and amplitude are not known, and what was worked out all the same stands under
/// `band_rms_estimate_m` and `tone_amplitude_estimate_m`. `is_alone`: the document has no other.
[[nodiscard]] document::Section TrialSection(const AnalyzedFile& file, bool is_alone);

/// What holds for all trials: what is in no uncertainty. `has_numbers`: some of them have one.
[[nodiscard]] document::Section ClosingSection(bool has_numbers);

}  // namespace haptometer::tools
