#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/quantity.h"
#include "dsp/analysis/band_question.h"
#include "tools/analyze/spectrum_options.h"
#include "tools/cli/band_question.h"
#include "tools/cli/import_words.h"
#include "tools/cli/options.h"

namespace haptometer::tools {

/// The command line of `analyze`, as it was typed.
struct AnalyzeWords {
  std::vector<std::string> files;
  cli::BandWords band{.band = "20-500Hz", .order = {}, .corner = "whole"};
  std::string window = "auto";
  std::string floor;
  std::optional<Quantity> drive_frequency_hz;
  bool all = false;
  bool sweep = false;
  std::string response;
  std::string plot;
  std::string report;
  std::optional<std::int64_t> threads;
  SpectrumWords spectrum;
  cli::ImportWords import;
};

void DeclareAnalyze(cli::Options* options, AnalyzeWords* words);

/// What is asked of each record; its floor is not read yet. Errors (Cause::kUsage): a band or
/// window that is none, a picture that cannot be drawn at its place.
[[nodiscard]] Result<dsp::BandQuestion> QuestionOf(const AnalyzeWords& words);

/// Threads as asked for, otherwise as many as there are cores.
[[nodiscard]] int ThreadsOf(const AnalyzeWords& words);

}  // namespace haptometer::tools
