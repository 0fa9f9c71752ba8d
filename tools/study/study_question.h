#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "dsp/analysis/band_analysis.h"
#include "tools/cli/options.h"

namespace haptometer::tools {

/// What is said of the filter; empty: as analyze has it.
struct BandWords {
  std::string band;  ///< "20-500Hz"
  std::optional<std::int64_t> order;
  std::string corner;  ///< "whole" or "each"
};

/// Declares --band, --order and --corner.
void DeclareBand(cli::Options* options, BandWords* words);

/// Errors (Cause::kUsage): no band-pass, before any file is read.
[[nodiscard]] Result<dsp::BandQuestion> QuestionOf(const BandWords& words);

}  // namespace haptometer::tools
