#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "dsp/analysis/band_analysis.h"
#include "tools/plot/gnuplot.h"
#include "trial/record.h"

namespace haptometer::tools {

/// One file's answer, or the error that stands in its place.
struct AnalyzedFile {
  std::string path;
  std::optional<dsp::BandAnalysis> analysis;
  std::optional<Error> error;
  std::string source;                ///< metadata.source; empty: the file does not say
  std::vector<std::string> remarks;  ///< what was lost of the file
};

/// Prints the answer in um and Hz on stdout, with every remark. Prints nothing for an error.
void PrintAnalysis(const AnalyzedFile& file);

/// The document of `analyze --json` (docs/commands.md), indented. Unknown values are null; an error
/// becomes the only entry of `reasons`.
[[nodiscard]] std::string AnalysisJson(const std::vector<AnalyzedFile>& files);

/// Distance over time, the filtered signal and ten periods of it; grey is what was left out.
[[nodiscard]] std::vector<plot::Panel> AnalysisPanels(const trial::Record& record,
                                                      const dsp::BandAnalysis& analysis);

}  // namespace haptometer::tools
