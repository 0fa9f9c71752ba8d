#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "sim/skin/skin_rise.h"
#include "tools/analyze/analyze.h"
#include "tools/report/html_page.h"

namespace haptometer::tools {

/// The document of `analyze --json` (docs/reference/analyze.md), indented. Unknown values are null;
/// an error becomes the only entry of `reasons`. Where a file is not answered, RMS and amplitude
/// are null and what was worked out all the same stands under `band_rms_estimate_m` and
/// `tone_amplitude_estimate_m`.
[[nodiscard]] std::string AnalysisJson(const std::vector<AnalyzedFile>& files);

/// One fact, as a person writes it down.
struct AnalysisLine {
  std::string label;  ///< empty: goes on with the line above
  std::string text;
};

/// Facts that belong together.
struct AnalysisSection {
  std::string heading;
  std::vector<AnalysisLine> lines;
};

/// What people write down, in um with two digits of uncertainty: vibration, window, tone, rise.
/// Where the question is not answered, what can be known and the estimate, called so.
/// `file.analysis` is there.
[[nodiscard]] std::vector<AnalysisLine> ShortLines(const AnalyzedFile& file);

/// Everything that the analysis holds, for `--all` and the report.
[[nodiscard]] std::vector<AnalysisSection> AllSections(const AnalyzedFile& file);

/// The settings that the numbers rest on, as the report names them.
[[nodiscard]] std::string DescribeFilter(const dsp::BandPass& band);

/// What a file's part of the report shows.
struct ReportedFile {
  AnalyzedFile file;
  std::vector<std::vector<plot::Panel>> figures;  ///< each one drawing
  std::vector<std::string> captions;              ///< one a figure
};

/// The page of `analyze --report`: per file its answer, its figures, everything that --all prints,
/// and the settings that the numbers rest on. `command` is how it was called.
/// Errors: as HtmlPage::Figure.
[[nodiscard]] Result<report::HtmlPage> AnalysisReport(const std::vector<ReportedFile>& files,
                                                      const std::string& command);

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
