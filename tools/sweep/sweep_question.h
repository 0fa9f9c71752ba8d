#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "sim/sweep/sweep_points.h"
#include "sim/sweep/varied_scene.h"
#include "tools/cli/options.h"

namespace haptometer::tools {

/// One of several parts of a sweep: points number - 1, number - 1 + count, ... from 0.
struct Shard {
  std::uint64_t number = 1;  ///< 1 to count
  std::uint64_t count = 1;

  /// How many of `points` points are its own.
  [[nodiscard]] std::uint64_t RowsOf(std::uint64_t points) const {
    return points < number ? 0 : (points - number) / count + 1;
  }
  /// The point in its row `row`, both from 0.
  [[nodiscard]] std::uint64_t PointOf(std::uint64_t row) const { return number - 1 + row * count; }
};

/// What a sweep asks.
struct SweepQuestion {
  sim::VariedScene scene;
  sim::SweepPoints points;
  Shard shard;
};

inline constexpr std::int64_t kMostSweepThreads = 1024;

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
  bool all = false;
  std::vector<std::string> command;  ///< the whole command line
};

void Declare(cli::Options& options, SweepWords& words);

/// The question of a sweep, its scene read and every key tried (tools/sweep/sweep_question.h).
/// Errors: Cause::kUsage for words that make no question, or more than 1e9 points; the scene's.
[[nodiscard]] Result<SweepQuestion> ReadQuestion(const SweepWords& words);

/// The tables to merge. Errors (Cause::kUsage): none, or an option that merging does not have.
[[nodiscard]] Result<std::vector<std::string>> ReadMerge(const SweepWords& words);

/// Whether ranges are a grid or are sampled.
enum class RangesAre : std::uint8_t { kGrid, kSampled };

/// Reads what --vary says of one key: "drive.frequency_hz=100Hz:400Hz:301", "KEY=log:1:1000:4", or
/// a list, "skin.stiffness_n_per_m=600,1200", "sensor.target=skin,case", "effects.inductance=true".
///
/// A number's unit is that of the key's name ("_hz"); other numbers are plain. A grid's range has a
/// count, one that is sampled has none. Errors (Cause::kUsage), naming --vary and the key: no '=',
/// values of another unit or with an uncertainty, an empty value, equal ends, a count below 2, a
/// logarithm of what is not above 0.
[[nodiscard]] Result<sim::SweepAxis> ReadVaryWord(const std::string& word, RangesAre ranges);

}  // namespace haptometer::tools
