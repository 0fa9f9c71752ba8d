#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "dsp/analysis/band_question.h"
#include "tools/cli/options.h"

namespace haptometer::cli {

/// What is said of the filter; empty: as BandQuestion has it.
struct BandWords {
  std::string band;  ///< "20-500Hz"
  std::optional<std::int64_t> order;
  std::string corner;  ///< "whole" or "each"
};

/// Declares --band, --order (shown where `order_shown` says) and --corner.
void DeclareBand(Options* options, BandWords* words, Shown order_shown);

/// The question about that band, everything else as BandQuestion has it. Errors (Cause::kUsage): no
/// band-pass, before any file is read.
[[nodiscard]] Result<dsp::BandQuestion> BandQuestionOf(const BandWords& words);

}  // namespace haptometer::cli
