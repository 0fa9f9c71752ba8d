#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_analysis.h"

namespace haptometer::tools {

/// One file's answer, or the error that stands in its place.
struct AnalyzedFile {
  std::string path;
  std::optional<dsp::BandAnalysis> analysis;
  std::optional<Error> error;
  std::string source;                ///< metadata.source; empty: the file does not say
  std::vector<std::string> remarks;  ///< what was lost of the file
};

}  // namespace haptometer::tools
