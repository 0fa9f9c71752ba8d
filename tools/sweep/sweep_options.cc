#include "tools/sweep/sweep_options.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <thread>
#include <utility>

#include "tools/sweep/axis_check.h"
#include "tools/sweep/vary_word.h"

namespace haptometer::tools {
namespace {

constexpr std::uint64_t kMostPoints = 1'000'000'000;
constexpr std::int64_t kMostThreads = 1024;
constexpr std::int64_t kMostSeed = (1LL << 62) - 1;
constexpr std::uint64_t kMostShards = 1'000'000;

std::optional<std::uint64_t> WholeNumber(std::string_view text) {
  std::uint64_t value = 0;
  const auto [stop, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc{} || stop != text.data() + text.size()) return std::nullopt;
  return value;
}

Result<Shard> ReadShard(const std::string& text) {
  if (text.empty()) return Shard{};
  const std::string_view word = text;
  const std::size_t slash = std::min(word.find('/'), word.size() - 1);
  const std::uint64_t number = WholeNumber(word.substr(0, slash)).value_or(0);
  const std::uint64_t count = WholeNumber(word.substr(slash + 1)).value_or(0);
  if (number < 1 || number > count || count > kMostShards) {
    return Usage("--shard", fmt::format("'{}' is not I/N", text),
                 "write 1/4 to 4/4 for the four parts of a sweep");
  }
  return Shard{.number = number, .count = count};
}

Result<std::vector<sim::SweepAxis>> ReadAxes(const SweepWords& words) {
  if (words.vary.empty()) {
    return Usage("--vary", "is missing", "add --vary drive.frequency_hz=100Hz:400Hz:301");
  }
  const RangesAre ranges = words.samples ? RangesAre::kSampled : RangesAre::kGrid;
  std::vector<sim::SweepAxis> axes;
  axes.reserve(words.vary.size());
  for (const std::string& word : words.vary) {
    auto axis = ReadVaryWord(word, ranges);
    if (!axis) return std::unexpected(axis.error());
    axes.push_back(*std::move(axis));
  }
  return axes;
}

Result<sim::SweepPoints> ReadPoints(const SweepWords& words) {
  auto axes = ReadAxes(words);
  if (!axes) return std::unexpected(axes.error());
  if (!words.samples && words.seed) {
    return Usage("--seed", "stands without --samples", "a grid has nothing random");
  }
  std::optional<sim::LatinHypercube> sampling;
  if (words.samples) {
    sampling = {.samples = static_cast<std::uint64_t>(*words.samples),
                .seed = static_cast<std::uint64_t>(words.seed.value_or(1))};
  }
  sim::SweepPoints points(*std::move(axes), sampling);
  if (points.size() > kMostPoints) {
    return Usage("--vary",
                 fmt::format("makes more than {:.0e} points", static_cast<double>(kMostPoints)),
                 "give fewer values, or --samples");
  }
  return points;
}

Result<void> CheckWords(const SweepWords& words) {
  if (words.scenes.empty()) {
    return Usage({}, "has no scene", "give a scene.toml, or tables to --merge");
  }
  if (words.scenes.size() > 1) {
    return Usage(words.scenes[1], "is a second scene", "sweep one at a time");
  }
  if (words.output.empty())
    return Usage("-o", "is missing", "say where the table goes: -o table.csv");
  if (words.resume && words.overwrite) {
    return Usage("--overwrite", "stands beside --resume", "give one of the two");
  }
  return {};
}

}  // namespace

void Declare(cli::Options& options, SweepWords& words) {
  options.Positionals("scene", &words.scenes, "A scene.toml (docs/notation.md)", 0);
  options.Repeated(
      "--vary", &words.vary, "KEY=VALUES",
      "A key of the scene and its values: BEGIN:END:COUNT, log:BEGIN:END:COUNT, A,B,C");
  options.Count("--samples", &words.samples, 1, static_cast<std::int64_t>(kMostPoints),
                "Points of a Latin hypercube over BEGIN:END instead of a grid");
  options.Count("--seed", &words.seed, 0, kMostSeed, "Of the samples; 1");
  options.Output("-o,--output", &words.output, "FILE.csv", "The table, a row for each point");
  options.Flag("--resume", &words.resume, "Go on with the table where a run was ended");
  options.Flag("--overwrite", &words.overwrite, "Replace the table where it exists");
  options.Count("--threads", &words.threads, 1, kMostThreads,
                "Default: as many as there are cores; no number depends on it");
  options.Text("--shard", &words.shard, "I/N", "Only every N-th point, from the I-th on");
  options.Groups("--merge", &words.merge, "TABLES", "Join the shards' tables into one");
  options.Text("--best", &words.best, "COLUMN[:least]", "Tell its largest row; skin_rms_m");
  options.Output("--plot", &words.plot, "FILE.svg|png|pdf",
                 "Draw that column over one or two varied keys");
}

Result<SweepQuestion> ReadQuestion(const SweepWords& words) {
  if (auto sound = CheckWords(words); !sound) return std::unexpected(sound.error());
  const auto shard = ReadShard(words.shard);
  if (!shard) return std::unexpected(shard.error());
  auto points = ReadPoints(words);
  if (!points) return std::unexpected(points.error());
  std::vector<std::string> keys;
  keys.reserve(points->axes().size());
  for (const sim::SweepAxis& axis : points->axes()) keys.push_back(axis.key);
  auto scene = sim::VariedScene::ReadFile(words.scenes.front(), keys);
  if (!scene) {
    Error error = scene.error();
    if (std::ranges::find(keys, error.where) != keys.end()) error.where = "--vary " + error.where;
    return std::unexpected(std::move(error));
  }
  if (auto taken = CheckAxes(*scene, *points); !taken) return std::unexpected(taken.error());
  return SweepQuestion{.scene = *std::move(scene), .points = *std::move(points), .shard = *shard};
}

Result<std::vector<std::string>> ReadMerge(const SweepWords& words) {
  std::vector<std::string> tables;
  for (const auto& group : words.merge) tables.insert(tables.end(), group.begin(), group.end());
  const bool has_others = !words.scenes.empty() || !words.vary.empty() || words.samples ||
                          words.seed || words.resume || words.threads || !words.shard.empty();
  if (has_others) {
    return Usage("--merge", "joins tables and computes nothing",
                 "give it tables, -o, --overwrite, --best and --plot alone");
  }
  if (words.output.empty())
    return Usage("-o", "is missing", "say where the table goes: -o whole.csv");
  return tables;
}

int ThreadsOf(const SweepWords& words) {
  const auto cores = std::max<std::int64_t>(1, std::thread::hardware_concurrency());
  return static_cast<int>(words.threads.value_or(std::min(cores, kMostThreads)));
}

}  // namespace haptometer::tools
