#include "tools/compare/compare.h"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "base/jobs.h"
#include "base/mapped.h"
#include "base/toml.h"
#include "sim/scene/plausible_ranges.h"
#include "sim/scene/scene_file.h"
#include "sim/scene/scene_keys.h"
#include "tools/cli/options.h"
#include "tools/cli/progress.h"
#include "tools/cli/shared_options.h"
#include "tools/cli/terminal.h"
#include "tools/document/present.h"
#include "tools/sweep/sweep.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "compare";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Compare trials with a scene, and name the inputs that would explain a difference.",
    .examples = {
        "haptometer compare trial.bin scene.toml",
        "haptometer compare a.bin b.bin scene.toml --input skin.stiffness_n_per_m=600:1200",
        "haptometer compare result.json scene.toml --report compare.html --json"}};

// --- inputs ---

Result<Quantity> ReadInput(const std::string& key, const std::string& text) {
  const std::string where = "--input " + key;
  const Dimension dimension = DimensionOfKey(key);
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) {
    HAPTOMETER_LET(const auto value, ParseQuantity(text, dimension, where));
    if (!value.exact()) return value;
    return Usage(where, fmt::format("'{}' has no uncertainty", text),
                 "write it like 600+-50, 600(50) or as a range 500:700");
  }
  HAPTOMETER_LET(const auto low, ParseQuantity(text.substr(0, colon), dimension, where));
  HAPTOMETER_LET(const auto high, ParseQuantity(text.substr(colon + 1), dimension, where));
  if (!(low.exact() && high.exact() && low.value < high.value)) {
    return Usage(where, fmt::format("'{}' is not a range", text), "write it as LOW:HIGH");
  }
  // rectangular: u = width / sqrt(12)
  return Quantity{(low.value + high.value) / 2, (high.value - low.value) / std::sqrt(12)};
}

constexpr std::string_view kActuatorTable = "actuator.";

// the place among an actuator's numbers that a key of the scene names
std::optional<std::size_t> PlaceOf(std::string_view key) {
  if (!key.starts_with(kActuatorTable)) return std::nullopt;
  const auto found = std::ranges::find(sim::kActuatorKeys, key.substr(kActuatorTable.size()));
  if (found == sim::kActuatorKeys.end()) return std::nullopt;
  return static_cast<std::size_t>(found - sim::kActuatorKeys.begin());
}

// whether the actuator's numbers stand in a file of their own, or in this program
Result<bool> HasActuatorElsewhere(const std::string& path) {
  HAPTOMETER_LET(auto root, TomlTable::ParseFile(path));
  const TomlTable* actuator = root.Table("actuator");
  return actuator != nullptr && (actuator->Has("file") || actuator->Has("model"));
}

// F of a matrix of correlations, by pivots: it may be of less than full rank
Result<Eigen::MatrixXd> FactorOf(const Eigen::MatrixXd& correlation, const std::string& path) {
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(correlation);
  if (correlation.size() > 0 && ldlt.vectorD().minCoeff() < -1e-9) {
    return CannotAnswer(path, "has correlations of the actuator that contradict each other",
                        "fit the actuator again, or remove [correlation]");
  }
  const Eigen::VectorXd root = ldlt.vectorD().cwiseMax(0).cwiseSqrt();
  const Eigen::MatrixXd lower = ldlt.matrixL();
  return Eigen::MatrixXd(ldlt.transpositionsP().transpose() * lower * root.asDiagonal());
}

// --- the command line ---

struct Words {
  std::vector<std::string> files, inputs, uncertainties;
  document::Outputs outputs;
};

void Declare(cli::Options& options, Words& words) {
  options.Positionals(
      "files", &words.files,
      "Trials, or results of analyze --json (.json), repeats of one measurement, and "
      "last the scene.toml",
      0);
  options
      .Repeated("--input", &words.inputs, "KEY=VALUE",
                "A key of the scene whose value is uncertain: KEY=600+-50, KEY=600(50), or a "
                "range KEY=600:1200")
      .Known({sim::kSceneKeys.begin(), sim::kSceneKeys.end()});
  options.Repeated("--uncertainty", &words.uncertainties, "KEY=U",
                   "A standard uncertainty that a measured quantity has besides analyze's, as "
                   "current_rms_a=1%");
  document::DeclareOutputs(
      options, words.outputs,
      {.all = "Print the provenance too", .plot = "Draw measured against simulated"});
}

bool IsScene(const std::string& path) { return path.ends_with(".toml"); }

Result<void> CheckFiles(const std::vector<std::string>& files) {
  const auto scenes = std::ranges::count_if(files, IsScene);
  const std::string last = files.empty() ? "" : files.back();
  return cli::CheckRules({
      {files.empty(), "", "has no trial and no scene", "write it as compare trial.bin scene.toml"},
      {scenes == 0, last, "is no scene, and none is given", "put the scene.toml last"},
      {scenes > 1, last, "is a second scene", "compare with one at a time"},
      {!IsScene(last), last, "stands behind the scene", "put the scene.toml last"},
      {files.size() == 1, last, "is compared with nothing", "put a trial before the scene"},
  });
}

}  // namespace

Result<std::vector<ComparedInput>> ReadInputs(const std::vector<std::string>& words) {
  HAPTOMETER_LET(const auto pairs,
                 cli::ReadKeyValues(words, "--input", "skin.stiffness_n_per_m=600+-50"));
  std::vector<ComparedInput> inputs;
  inputs.reserve(pairs.size());
  for (const auto& [key, text] : pairs) {
    HAPTOMETER_LET(const auto value, ReadInput(key, text));
    inputs.push_back({.key = key, .value = value, .is_range = text.find(':') != std::string::npos});
  }
  return inputs;
}

Result<ComparedScene> ComparedScene::Read(const std::string& path,
                                          std::vector<ComparedInput> inputs) {
  // an error of the file itself is told with its line
  HAPTOMETER_LET(const auto stated, sim::ReadSceneFile(path));
  HAPTOMETER_LET(const bool is_elsewhere, HasActuatorElsewhere(path));
  std::vector<std::string> keys;
  for (ComparedInput& input : inputs) {
    if (is_elsewhere) input.symbol = PlaceOf(input.key);
    if (!input.symbol) keys.push_back(input.key);
    // it is varied by factors
    const double value = input.value.value;
    if (!input.symbol || (value >= sim::kSmallest && value <= sim::kLargest)) continue;
    return Usage("--input " + input.key,
                 fmt::format("{:g} is outside {:g} to {:g}", value, sim::kSmallest, sim::kLargest),
                 "check its sign and its unit");
  }
  auto varied = sim::VariedScene::ReadFile(path, keys);
  if (!varied) {
    Error error = varied.error();
    if (error.where != path) error.where = "--input " + error.where;
    return std::unexpected(std::move(error));
  }
  ComparedScene scene(*std::move(varied), std::move(inputs));
  scene.target_ = TargetOf(stated);
  HAPTOMETER_LET(const auto at, scene.At(Eigen::VectorXd::Zero(std::ssize(scene.inputs_))));
  sim::DoubtUnusual(at, scene.unusual_);
  HAPTOMETER_TRY(scene.TakeActuator(at.actuator_covariance, at.actuator));
  return scene;
}

Result<void> ComparedScene::TakeActuator(sim::ActuatorCovariance covariance,
                                         const sim::Actuator& actuator) {
  // what is stated of a number replaces the file's uncertainty, and its correlations
  for (const ComparedInput& input : inputs_) {
    if (!input.symbol) continue;
    for (auto& row : covariance) row[*input.symbol] = 0;
    covariance[*input.symbol] = {};
  }
  const std::size_t stated = inputs_.size();
  for (std::size_t k = 0; k < covariance.size(); ++k) {
    if (covariance[k][k] == 0) continue;
    const double value = actuator.*sim::kActuatorNumbers[k];
    inputs_.push_back({.key = std::string(kActuatorTable) + std::string(sim::kActuatorKeys[k]),
                       .value = {value, value * std::sqrt(covariance[k][k])},
                       .symbol = k});
  }
  const auto count = static_cast<Eigen::Index>(inputs_.size());
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(count, count);
  for (std::size_t i = stated; i < inputs_.size(); ++i) {
    for (std::size_t j = stated; j < i; ++j) {
      const std::size_t one = *inputs_[i].symbol, other = *inputs_[j].symbol;
      const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(j);
      correlation(row, column) =
          covariance[one][other] / std::sqrt(covariance[one][one] * covariance[other][other]);
      correlation(column, row) = correlation(row, column);
    }
  }
  HAPTOMETER_LET(factor_, FactorOf(correlation, path()));
  return {};
}

std::size_t ComparedScene::InputOf(Eigen::Index k) const {
  Eigen::Index most = 0;
  factor_.col(k).cwiseAbs().maxCoeff(&most);
  return static_cast<std::size_t>(most);
}

Result<sim::Scene> ComparedScene::At(const Eigen::VectorXd& steps) const {
  std::vector<sim::SweepValue> values;
  std::string changed;
  for (std::size_t k = 0; k < inputs_.size(); ++k) {
    if (inputs_[k].symbol) continue;
    const Quantity& value = inputs_[k].value;
    const double step = steps(static_cast<Eigen::Index>(k));
    values.push_back(sim::NumberValue(value.value + step * value.standard_uncertainty));
    if (step != 0 || changed.empty()) {
      changed = fmt::format("{} = {}", inputs_[k].key, values.back().text);
    }
  }
  auto scene = scene_.Read(values);
  if (!scene) {
    Error error = scene.error();
    error.what = sim::WithoutPath({error.cause, error.where, error.what, ""}, path());
    error.where = "--input " + changed;
    return std::unexpected(std::move(error));
  }
  for (std::size_t k = 0; k < inputs_.size(); ++k) {
    if (!inputs_[k].symbol) continue;
    const Quantity& value = inputs_[k].value;
    const double step = steps(static_cast<Eigen::Index>(k));
    scene->actuator.*sim::kActuatorNumbers[*inputs_[k].symbol] =
        value.value * std::exp(step * value.standard_uncertainty / value.value);
  }
  return scene;
}

int RunCompare(int argc, const char* const* argv) {
  cli::Options options(kText);
  Words words;
  Declare(options, words);
  const auto answer = [&]() -> Result<int> {
    HAPTOMETER_TRY(CheckFiles(words.files));
    HAPTOMETER_LET(auto inputs, ReadInputs(words.inputs));
    HAPTOMETER_LET(const auto scene, ComparedScene::Read(words.files.back(), std::move(inputs)));
    HAPTOMETER_LET(auto measured,
                   ReadMeasured(std::span(words.files).first(words.files.size() - 1)));
    HAPTOMETER_TRY(AddUncertainties(words.uncertainties, scene.target(), {&measured, 1}));
    cli::WorkProgress progress(kVerb, "fewer --input take less");
    const WatchedWork watched(
        [&](std::string_view what, double share) { progress.Update(what, share); });
    HAPTOMETER_LET(const auto propagation, Propagate(scene, measured));
    ComparisonResult result = Compare(measured.numbers, scene, propagation);
    FindCauses(scene, propagation, result);
    if (result.quantities.empty()) {
      return CannotAnswer(words.files.front(), "has no quantity that the scene has too",
                          "see docs/reference/compare.md for what is compared");
    }
    const int status =
        document::Present(CompareDocument(measured, scene, result, words.outputs.HasFigures()),
                          words.outputs, argc, argv);
    // a difference, and trials without a mean, end as a question that is not answered does
    const bool is_open = result.Differs() || !measured.scattered.empty();
    return cli::WorseStatus(status, is_open ? ExitStatus(Cause::kCannotAnswer) : 0);
  };
  return document::RunVerb(kVerb, options, words.outputs, argc, argv, answer);
}

}  // namespace haptometer::tools
