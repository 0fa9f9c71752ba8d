#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "tools/cli/options.h"
#include "tools/sweep/sweep_question.h"

namespace haptometer::tools {

/// What the command line of sweep says.
struct SweepWords {
  std::vector<std::string> scenes;
  std::vector<std::string> vary;
  std::optional<std::int64_t> samples;
  std::optional<std::int64_t> seed;
  std::string output;
  bool resume = false;
  bool overwrite = false;
  std::optional<std::int64_t> threads;
  std::string shard;
  std::vector<std::vector<std::string>> merge;
  std::string best = "skin_rms_m";
  std::string plot;
};

void Declare(cli::Options& options, SweepWords& words);

/// The question of a sweep, its scene read and every key tried (tools/sweep/axis_check.h).
/// Errors: Cause::kUsage for words that make no question, or more than 1e9 points; the scene's.
[[nodiscard]] Result<SweepQuestion> ReadQuestion(const SweepWords& words);

/// The tables to merge. Errors (Cause::kUsage): none, or an option that merging does not have.
[[nodiscard]] Result<std::vector<std::string>> ReadMerge(const SweepWords& words);

/// As asked for, else one a core.
[[nodiscard]] int ThreadsOf(const SweepWords& words);

}  // namespace haptometer::tools
