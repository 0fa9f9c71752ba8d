#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/skin/skin_rise.h"
#include "tools/analyze/analyze.h"
#include "tools/document/document.h"

namespace haptometer::tools {

/// The document of `count` trials before any is analysed; the first of them is `first`.
[[nodiscard]] document::Document AnalysisDocument(const std::string& first, std::size_t count);

/// What is known of one trial (docs/reference/analyze.md). Where the question is not answered, RMS
/// and amplitude are not known, and what was worked out all the same stands under
/// `band_rms_estimate_m` and `tone_amplitude_estimate_m`. `is_alone`: the document has no other.
[[nodiscard]] document::Section TrialSection(const AnalyzedFile& file, bool is_alone);

/// Says of the section where its data come from.
void AddSources(std::vector<trial::DataSource> sources, document::Section& section);

/// What holds for all trials: what the uncertainties exclude. `has_numbers`: some of them have one.
[[nodiscard]] document::Section ClosingSection(bool has_numbers);

/// What a latency is to a user (Lindsay 2013, p. 4): from 25 ms on it costs errors, from 50 ms on
/// it is perceived.
[[nodiscard]] std::string_view LatencyVerdict(double latency_s);

/// The same of a simulated latency, if it is so from an uncertainty below to one above it.
[[nodiscard]] std::string_view LatencyVerdict(const sim::SkinRise& rise);

/// "2.935 ms, to 0.67 ms", or "below 2.495 ms" where the latency is not above its uncertainty.
[[nodiscard]] std::string LatencyText(const sim::SkinRise& rise);

/// What a latency that is not above its uncertainty is below; nothing of one that is.
[[nodiscard]] std::optional<double> LatencyBelowS(const sim::SkinRise& rise);

}  // namespace haptometer::tools
