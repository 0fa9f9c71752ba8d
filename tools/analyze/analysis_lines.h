#pragma once

#include <string>
#include <vector>

#include "tools/analyze/analyzed_file.h"

namespace haptometer::tools {

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

}  // namespace haptometer::tools
