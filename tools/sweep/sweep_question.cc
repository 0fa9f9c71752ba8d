#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "base/mapped.h"
#include "base/quantity.h"
#include "base/text.h"
#include "sim/effect_choice.h"
#include "sim/scene/plausible_ranges.h"
#include "sim/scene/scene_file.h"
#include "sim/scene/scene_keys.h"
#include "tools/document/number_text.h"
#include "tools/sweep/sweep.h"

namespace haptometer::tools {
namespace {

constexpr std::uint64_t kMostPoints = 1'000'000'000;
constexpr std::int64_t kMostSeed = (1LL << 62) - 1;

Result<std::vector<sim::SweepAxis>> ReadAxes(const SweepWords& words) {
  if (words.vary.empty()) {
    return Usage("--vary", "is missing", "add --vary drive.frequency_hz=100Hz:400Hz:301");
  }
  // with --samples a range has no count
  const RangesAre ranges = words.samples ? RangesAre::kSampled : RangesAre::kGrid;
  std::vector<sim::SweepAxis> axes;
  axes.reserve(words.vary.size());
  for (const std::string& word : words.vary) {
    HAPTOMETER_LET(auto axis, ReadVaryWord(word, ranges));
    axes.push_back(std::move(axis));
  }
  return axes;
}

Result<sim::SweepPoints> ReadPoints(const SweepWords& words) {
  HAPTOMETER_LET(auto axes, ReadAxes(words));
  if (!words.samples && words.seed) {
    return Usage("--seed", "needs --samples", "a grid has nothing random");
  }
  std::optional<sim::LatinHypercube> sampling;
  // Latin hypercube; seed 1 unless stated, so that a sweep is reproducible
  if (words.samples) {
    sampling = {.samples = static_cast<std::uint64_t>(*words.samples),
                .seed = static_cast<std::uint64_t>(words.seed.value_or(1))};
  }
  sim::SweepPoints points(std::move(axes), sampling);
  if (points.size() > kMostPoints) {
    return Usage("--vary",
                 fmt::format("makes more than {:.0e} points", static_cast<double>(kMostPoints)),
                 "give fewer values, or --samples");
  }
  return points;
}

Result<void> CheckWords(const SweepWords& words) {
  const bool has_second = words.scenes.size() > 1;
  return cli::CheckRules({
      {words.scenes.empty(), "", "has no scene", "give a scene.toml, or tables to --merge"},
      {has_second, has_second ? words.scenes[1] : "", "is a second scene", "sweep one at a time"},
      {words.output.empty(), "-o", "is missing", "name the table: -o table.csv"},
      {words.resume && words.overwrite, "--overwrite", "cannot be combined with --resume",
       "give one of the two"},
      {words.is_mixed_allowed && !words.resume && !words.slurm.jobs, "--allow-mixed",
       "applies to --resume, --merge and --slurm only, none of which is given", "leave it out"},
      CampaignRule(words.slurm),
  });
}

constexpr std::string_view kLogarithmic = "log:";
constexpr std::int64_t kMostValues = 1'000'000'000;

std::vector<std::string> SplitAt(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t at = text.find(separator); at != std::string::npos;
       at = text.find(separator, begin)) {
    parts.push_back(text.substr(begin, at - begin));
    begin = at + 1;
  }
  parts.push_back(text.substr(begin));
  return parts;
}

// a number in SI units of the key's dimension, without uncertainty
Result<double> ReadNumber(const std::string& word, Dimension dimension, const std::string& where) {
  HAPTOMETER_LET(const auto quantity, ParseQuantity(word, dimension, where, BareNumber::kIsSi));
  if (!quantity.exact()) {
    return Usage(where, fmt::format("'{}' has an uncertainty", word),
                 "give exact values to a sweep");
  }
  return quantity.value;
}

// one value of a list
Result<sim::SweepValue> ReadValue(const std::string& word, Dimension dimension,
                                  const std::string& where) {
  // control characters would break the lines of the table
  const bool has_control = std::ranges::any_of(
      word, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
  if (word.empty() || has_control) {
    return Usage(where, "has a value that is empty or not printable", "write it as KEY=A,B,C");
  }
  if (dimension == Dimension::kNone) {
    // without a dimension: integer, boolean, number, else a text
    if (const auto whole = NumberFrom<std::int64_t>(word))
      return sim::PlainValue(fmt::format("{}", *whole));
    if (word == "true" || word == "false") return sim::PlainValue(word);
    if (!ParseQuantity(word, dimension, where)) return sim::TextValue(word);
  }
  HAPTOMETER_LET(const auto number, ReadNumber(word, dimension, where));
  return sim::NumberValue(number);
}

// a range begins with a number or "log:"; a text may contain a colon ("C:/actuator.toml")
bool IsRange(const std::string& text) {
  if (text.starts_with(kLogarithmic)) return true;
  return text.find(':') != std::string::npos &&
         std::string_view("0123456789+-.").find(text[0]) != std::string_view::npos;
}

Result<std::size_t> ReadCount(const std::vector<std::string>& parts, RangesAre ranges,
                              const std::string& where) {
  if (ranges == RangesAre::kSampled) {
    if (parts.size() == 2) return std::size_t{0};
    return Usage(where, "is to be sampled, so it is BEGIN:END",
                 "leave out the count, or --samples");
  }
  if (parts.size() != 3) {
    return Usage(where, "is not BEGIN:END:COUNT",
                 "write it like 100Hz:400Hz:301, or give --samples");
  }
  const auto count = NumberFrom<std::int64_t>(parts[2]);
  if (!count || *count < 2 || *count > kMostValues) {
    return Usage(where, fmt::format("'{}' is not a count of values", parts[2]),
                 "give 2 or more, both ends among them");
  }
  return static_cast<std::size_t>(*count);
}

Result<sim::SweepRange> ReadRange(std::string text, Dimension dimension, RangesAre ranges,
                                  const std::string& where) {
  sim::SweepRange range;
  if (text.starts_with(kLogarithmic)) {
    range.spacing = sim::Spacing::kLogarithmic;
    text = text.substr(kLogarithmic.size());
  }
  const std::vector<std::string> parts = SplitAt(text, ':');
  HAPTOMETER_LET(range.count, ReadCount(parts, ranges, where));
  HAPTOMETER_LET(const auto begin, ReadNumber(parts[0], dimension, where));
  HAPTOMETER_LET(const auto end, ReadNumber(parts[1], dimension, where));
  range.begin = begin;
  range.end = end;
  // equal or infinite ends: their difference is 0 or not a number
  if (!(range.end - range.begin != 0 && std::isfinite(range.end - range.begin))) {
    return Usage(where, "has ends between which there is nothing", "give a single value alone");
  }
  // a logarithmic range has equal ratios, which need ends above 0
  if (range.spacing == sim::Spacing::kLogarithmic && !(range.begin > 0 && range.end > 0)) {
    return Usage(where, "is logarithmic and reaches to 0 or below", "give ends above 0");
  }
  return range;
}

// values that are read through the scene before the sweep
constexpr std::size_t kMostOfList = 1000;
constexpr std::size_t kMostOfRange = 100;
constexpr std::uint64_t kSampledChecked = 8;

// about kMostOfList or kMostOfRange values of an axis at most, with both ends as first and last
std::vector<sim::SweepValue> ValuesToCheck(const sim::SweepPoints& points, std::size_t number) {
  const sim::SweepAxis& axis = points.axes()[number];
  std::vector<sim::SweepValue> values;
  // a grid or a list: every step-th value and the last one
  if (const std::size_t count = CountOf(axis); count > 0) {
    const bool is_range = std::holds_alternative<sim::SweepRange>(axis.values);
    const std::size_t most = is_range ? kMostOfRange : kMostOfList;
    const std::size_t step = (count + most - 1) / most;
    values.reserve(count / step + 4);
    for (std::size_t index = 0; index < count; index += step) {
      values.push_back(ValueOf(axis, index));
    }
    // the values beside the ends: an end of 0 is usual where the least of the others is not
    if (step > 1) values.push_back(ValueOf(axis, 1));
    if (step > 1) values.push_back(ValueOf(axis, count - 2));
    values.push_back(ValueOf(axis, count - 1));
    return values;
  }
  // a sampled range: both ends and the first samples
  const auto& range = std::get<sim::SweepRange>(axis.values);
  values.push_back(sim::NumberValue(range.begin));
  for (std::uint64_t point = 0; point < std::min(points.size(), kSampledChecked); ++point) {
    values.push_back(points.At(point)[number]);
  }
  values.push_back(sim::NumberValue(range.end));
  return values;
}

// whether the reader's error concerns this key, or the first table on its path
bool IsAbout(const Error& error, const std::string& key) {
  const std::size_t dot = key.rfind('.');
  const std::string leaf = dot == std::string::npos ? key : key.substr(dot + 1);
  const std::string root = key.substr(0, key.find('.'));
  return error.where.ends_with(": " + leaf) ||
         error.what == fmt::format("key {} is not known", leaf) ||
         error.what == fmt::format("key {} is not known", root);
}

// an error of the file itself is reported with its line, one of a varied key with its value
Error Told(const sim::VariedScene& scene, const sim::SweepPoints& points,
           const std::vector<sim::SweepValue>& values, Error error) {
  const auto as_it_stands = sim::ReadSceneFile(scene.path());
  // the file without the sweep has the same error
  if (!as_it_stands && as_it_stands.error().what == error.what) return as_it_stands.error();
  for (std::size_t axis = 0; axis < values.size(); ++axis) {
    const std::string& key = points.axes()[axis].key;
    if (!IsAbout(error, key)) continue;
    Error bare = error;
    bare.remedy.clear();
    return {error.cause, fmt::format("--vary {} = {}", key, values[axis].text),
            sim::WithoutPath(bare, scene.path()), std::move(error.remedy)};
  }
  return error;
}

// Whether the scene takes what the axes give it: each value with the other keys at their first
// values and at their last. One that is refused only beside others is for the row of its point to
// tell. Returns unusual numbers of these scenes, and what the scene states and none uses. Cost:
// about 20 us a value.
Result<sim::Findings> CheckAxes(const sim::VariedScene& scene, const sim::SweepPoints& points) {
  std::vector<std::vector<sim::SweepValue>> values;
  values.reserve(points.axes().size());
  for (std::size_t axis = 0; axis < points.axes().size(); ++axis) {
    values.push_back(ValuesToCheck(points, axis));
  }
  const auto first = Mapped(values, [](const auto& of_axis) { return of_axis.front(); });
  const auto last = Mapped(values, [](const auto& of_axis) { return of_axis.back(); });
  // of each key the ends are named first where they are unusual
  sim::Findings findings;
  for (std::size_t axis = 0; axis < values.size(); ++axis) {
    for (const sim::SweepValue& end : {values[axis].front(), values[axis].back()}) {
      auto beside_first = first;
      beside_first[axis] = end;
      if (const auto read = scene.Read(beside_first)) sim::DoubtUnusual(*read, findings);
    }
  }
  // every value is tried beside the first and beside the last values of all other axes
  for (std::size_t axis = 0; axis < values.size(); ++axis) {
    for (const sim::SweepValue& value : values[axis]) {
      auto beside_first = first;
      beside_first[axis] = value;
      auto read = scene.Read(beside_first);
      if (read) {
        sim::DoubtUnusual(*read, findings);
        continue;
      }
      // valid in one of both combinations: the error belongs to a point, not to the axis
      auto beside_last = last;
      beside_last[axis] = value;
      if (scene.Read(beside_last)) continue;
      return std::unexpected(Told(scene, points, beside_first, std::move(read.error())));
    }
  }
  if (const auto read = scene.Read(last)) sim::DoubtUnusual(*read, findings);
  // an effect or a duration that is varied is on at some points
  const bool is_used = std::ranges::any_of(points.axes(), [](const sim::SweepAxis& axis) {
    return axis.key.starts_with("effects") || axis.key == "skin.contact" ||
           axis.key == "run.duration_s" || axis.key.starts_with("drive.kind");
  });
  if (const auto read = scene.Read(first); read && !is_used) sim::NoteUnused(*read, findings);
  return findings;
}

}  // namespace

void Declare(cli::Options& options, SweepWords& words) {
  options.Positionals("scene", &words.scenes, "A scene.toml (docs/reference/scene.md)", 0)
      .is_repeated = false;
  options
      .Repeated("--vary", &words.vary, "KEY=VALUES",
                "A key of the scene and its values: BEGIN:END:COUNT, log:BEGIN:END:COUNT, A,B,C")
      .Known({sim::kSceneKeys.begin(), sim::kSceneKeys.end()});
  DeclareAccuracy(options, words.accuracy);
  options.Count("--samples", &words.samples, 1, static_cast<std::int64_t>(kMostPoints),
                "Points of a Latin hypercube over BEGIN:END instead of a grid");
  options.Count("--seed", &words.seed, 0, kMostSeed, "Seed of the samples").Default("1");
  options.Output("-o,--output", &words.output, "FILE.csv",
                 "Table to write, with a row for each point");
  options.Flag("--resume", &words.resume, "Continue the table of an interrupted run");
  options.Flag("--overwrite", &words.overwrite, "Replace the table where it exists");
  options
      .Count("--threads", &words.threads, 1, kMostSweepThreads,
             "Number of threads; no result depends on it")
      .Default("the number of cores");
  options.Text("--shard", &words.shard, "I/N", "Compute only every N-th point, from the I-th on");
  options.Groups("--merge", &words.merge, "TABLE.csv...", "Join the shards' tables into one");
  options.Flag("--allow-mixed", &words.is_mixed_allowed,
               "Continue or join tables that different programs or processors computed",
               cli::Shown::kHelpAll);
  options.Text("--best", &words.best, "COLUMN[:least]",
               "Show the row with the largest number of this column");
  options.Flag("--all", &words.outputs.all, "Print the provenance too");
  options.Output("--plot", &words.plot, "FILE.svg|png|pdf",
                 "Draw the column of --best over one or two varied keys");
  DeclareSlurm(options, words.slurm);
  options.Exclude("--slurm", {"--shard", "--resume", "--merge"}, "the campaign does that itself");
}

Result<SweepQuestion> ReadQuestion(const SweepWords& words) {
  HAPTOMETER_TRY(CheckWords(words));
  HAPTOMETER_LET(const auto shard, cli::ReadShard(words.shard));
  HAPTOMETER_LET(auto points, ReadPoints(words));
  const std::vector<std::string> keys = Mapped(points.axes(), &sim::SweepAxis::key);
  auto scene = sim::VariedScene::ReadFile(words.scenes.front(), keys);
  if (!scene) {
    // an error about a varied key names the option
    Error error = scene.error();
    if (std::ranges::find(keys, error.where) != keys.end()) error.where = "--vary " + error.where;
    return std::unexpected(std::move(error));
  }
  const std::optional<double> accuracy = words.accuracy.Asked();
  if (accuracy && std::ranges::find(keys, "run.tolerance") != keys.end()) {
    return Usage("--vary run.tolerance", "varies the accuracy, which --accuracy or --digits fixes",
                 "give one of the two");
  }
  // before the first row: values at the ends of every axis must be accepted by the scene's reader
  HAPTOMETER_LET(auto findings, CheckAxes(*scene, points));
  return SweepQuestion{.scene = *std::move(scene),
                       .points = std::move(points),
                       .shard = shard,
                       .accuracy = accuracy,
                       .findings = std::move(findings)};
}

Result<std::vector<std::string>> ReadMerge(const SweepWords& words) {
  std::vector<std::string> tables;
  for (const auto& group : words.merge) tables.insert(tables.end(), group.begin(), group.end());
  // a merge computes nothing: options of a computation are refused
  const bool has_others = !words.scenes.empty() || !words.vary.empty() || words.samples ||
                          words.seed || words.resume || words.threads || !words.shard.empty() ||
                          words.accuracy.Asked() || CampaignRule(words.slurm).is_broken;
  HAPTOMETER_TRY(cli::CheckRules({
      {has_others, "--merge", "joins tables and computes nothing",
       "give it tables, -o, --overwrite, --best and --plot alone"},
      {words.output.empty(), "-o", "is missing", "name the table: -o whole.csv"},
  }));
  return tables;
}

Dimension DimensionOfKey(std::string_view key) {
  const document::Unit unit = document::UnitOfName(key);
  // "..._per_kg" is a quotient whose unit is not known: a plain number
  key.remove_suffix(unit.ending.size());
  if (unit.symbol.empty() || key.ends_with("_per")) return Dimension::kNone;
  for (auto number = static_cast<int>(Dimension::kArea); number > 0; --number) {
    if (SiUnit(static_cast<Dimension>(number)) == unit.symbol)
      return static_cast<Dimension>(number);
  }
  return Dimension::kNone;
}

Result<sim::SweepAxis> ReadVaryWord(const std::string& word, RangesAre ranges) {
  const std::size_t equals = word.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == word.size()) {
    return Usage("--vary", fmt::format("'{}' is not KEY=VALUES", word),
                 "write it like drive.frequency_hz=100Hz:400Hz:301");
  }
  sim::SweepAxis axis{.key = word.substr(0, equals), .values = {}};
  const std::string where = fmt::format("--vary {}", axis.key);
  // every number of a scene stands in a table
  if (!axis.key.contains('.')) {
    return Usage(where, "is no key of a scene", "name its table too, as drive.frequency_hz");
  }
  const std::string text = word.substr(equals + 1);
  const Dimension dimension = DimensionOfKey(axis.key);
  if (IsRange(text)) {
    HAPTOMETER_LET(axis.values, ReadRange(text, dimension, ranges, where));
    return axis;
  }
  std::vector<sim::SweepValue> values;
  for (const std::string& part : SplitAt(text, ',')) {
    HAPTOMETER_LET(auto value, ReadValue(part, dimension, where));
    values.push_back(std::move(value));
  }
  axis.values = std::move(values);
  return axis;
}

}  // namespace haptometer::tools
