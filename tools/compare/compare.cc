#include "tools/compare/compare.h"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string_view>
#include <utility>

#include "base/input_file.h"
#include "base/jobs.h"
#include "base/mapped.h"
#include "base/text.h"
#include "sim/linear/linear_model.h"
#include "sim/scene/scene_file.h"
#include "tools/analyze/analyze.h"
#include "tools/cli/options.h"
#include "tools/cli/progress.h"
#include "tools/cli/shared_options.h"
#include "tools/cli/terminal.h"
#include "tools/document/keys.h"
#include "tools/document/present.h"
#include "tools/document/render.h"
#include "tools/simulate/scene_answer.h"
#include "tools/sweep/sweep.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kVerb = "compare";
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr std::array kSources{document::DataSource::kDevice, document::DataSource::kEmulated,
                              document::DataSource::kSimulated, document::DataSource::kImported,
                              document::DataSource::kInterrupted};

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Compare trials with a scene, and name the inputs that would explain a difference.",
    .examples = {
        "haptometer compare trial.bin scene.toml",
        "haptometer compare a.bin b.bin scene.toml --input skin.stiffness_n_per_m=600:1200",
        "haptometer compare result.json scene.toml --report compare.html --json"}};

// --- the measurement ---

// where a trial of analyze --json has a quantity and its standard uncertainty
constexpr std::array<std::array<const char*, 2>, kComparedCount> kPlaces{
    {{"/band_rms_m", "/band_rms_standard_uncertainty_m"},
     {"/tone_frequency_hz", "/tone_frequency_standard_uncertainty_hz"},
     {"/onset/rise_s", "/onset/rise_standard_uncertainty_s"},
     {"/electrical/current_rms_a/value", "/electrical/current_rms_a/standard_uncertainty"},
     {"/electrical/real_power_w/value", "/electrical/real_power_w/standard_uncertainty"},
     {"/electrical/phase_rad/value", "/electrical/phase_rad/standard_uncertainty"}}};

// what stands at a place, null for nothing
const Json& At(const Json& json, const char* place) {
  static const Json none;
  const Json::json_pointer pointer(place);
  return json.contains(pointer) ? json.at(pointer) : none;
}

double NumberAt(const Json& json, const char* place, double otherwise = kNan) {
  const Json& found = At(json, place);
  return found.is_number() ? found.get<double>() : otherwise;
}

std::string TextAt(const Json& json, const char* place, const std::string& otherwise) {
  const Json& found = At(json, place);
  return found.is_string() ? Printable(found.get<std::string>()) : otherwise;
}

// the trials of documents, one after the other
class Trials {
 public:
  Result<void> AddDocument(const std::string& text, const std::string& path) {
    const Json json = Json::parse(text, nullptr, false);
    const Json& list = At(json, "/trials");
    if (!list.is_array() || list.empty()) return NoResult(path);
    for (const Json& trial : list) HAPTOMETER_TRY(Add(trial, path));
    for (const Json& finding : At(json, "/findings")) {
      if (TextAt(finding, "/severity", "") != "doubt") continue;
      measured_.doubts.push_back(fmt::format("{}: {}", TextAt(finding, "/subject", path),
                                             TextAt(finding, "/text", "not stated")));
    }
    return {};
  }

  // u^2 = s^2 / n + mean of u_i^2
  MeasuredNumbers Mean() {
    for (std::size_t k = 0; k < kComparedCount; ++k) {
      const auto n = static_cast<double>(repeats_[k].size());
      if (n == 0) continue;
      double mean = 0, variance = 0, scatter = 0;
      for (const dsp::Estimate& one : repeats_[k]) mean += one.value / n;
      for (const dsp::Estimate& one : repeats_[k]) {
        variance += one.uncertainty * one.uncertainty / n;
        scatter += (one.value - mean) * (one.value - mean);
      }
      if (n > 1) variance += scatter / (n - 1) / n;
      const double u = std::sqrt(variance);
      if (u > 0 && std::isfinite(u)) measured_.numbers[k] = {mean, u};
    }
    return measured_;
  }

 private:
  static std::unexpected<Error> NoResult(const std::string& path) {
    return CannotAnswer(path, "is no result of analyze",
                        "give a trial, or what analyze --json printed of trials");
  }

  Result<void> Add(const Json& trial, const std::string& path) {
    const Json& answered = At(trial, "/answered");
    if (!answered.is_boolean() || !trial.contains("band_rms_m")) return NoResult(path);
    const std::string file = TextAt(trial, "/file", path);
    if (!answered.get<bool>()) {
      return CannotAnswer(file, TextAt(trial, "/reasons/0", "has no answer"),
                          "leave this trial out");
    }
    measured_.files.push_back(file);
    for (std::size_t k = 0; k < kComparedCount; ++k) {
      const dsp::Estimate number{NumberAt(trial, kPlaces[k][0]), NumberAt(trial, kPlaces[k][1])};
      // a number whose uncertainty is not known is compared with nothing
      if (std::isfinite(number.value) && number.uncertainty > 0) repeats_[k].push_back(number);
    }
    for (const Json& name : At(trial, "/data_source")) {
      for (const auto source : kSources) {
        const bool is_new = std::ranges::count(measured_.sources, source) == 0;
        if (is_new && TextAt(name, "", "") == trial::NameOf(source))
          measured_.sources.push_back(source);
      }
    }
    measured_.lower_hz = std::max(measured_.lower_hz, NumberAt(trial, "/band/lower_hz", 0));
    measured_.upper_hz = std::min(measured_.upper_hz, NumberAt(trial, "/band/upper_hz", HUGE_VAL));
    measured_.is_calibrated &= At(trial, "/calibration_relative_standard_uncertainty").is_number();
    return {};
  }

  MeasuredNumbers measured_;
  std::array<std::vector<dsp::Estimate>, kComparedCount> repeats_;
};

// a document begins with a brace, which no recording does; anything else is analysed
Result<std::string> DocumentOf(const std::string& path) {
  if (std::ifstream(path).get() == '{') return ReadInputFile(path, std::uint64_t{64} << 20U);
  HAPTOMETER_LET(auto file, AnalyzeByDefault(path));
  if (file.error) return std::unexpected(std::move(*file.error));
  document::Document document = AnalysisDocument(path, 1);
  document.root.sections.back().sections.push_back(TrialSection(file, true));
  return document::JsonOf(document);
}

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

// keys of an actuator in the order of sim::kActuatorSymbols
constexpr std::array<std::string_view, 7> kActuatorKeys{
    "actuator.moving_mass_kg",    "actuator.case_mass_kg",           "actuator.stiffness_n_per_m",
    "actuator.damping_n_s_per_m", "actuator.force_constant_n_per_a", "actuator.resistance_ohm",
    "actuator.inductance_h"};

double NumberOf(const sim::Actuator& a, std::size_t place) {
  return std::array{a.moving_mass_kg,    a.case_mass_kg,           a.stiffness_n_per_m,
                    a.damping_n_s_per_m, a.force_constant_n_per_a, a.resistance_ohm,
                    a.inductance_h}[place];
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

// --- the scene ---

// a number of the steady motion, or of what the scene settles to, or of its run
double NumberOf(const SceneAnswer& answer, const document::Key& key) {
  for (const auto numbers : {SteadyNumbers(), RunNumbers()}) {
    for (const AnswerNumber& number : numbers) {
      if (number.key.name != key.name) continue;
      if (const auto value = number.of(answer)) return *value;
    }
  }
  return kNan;
}

// of the motion without its constant part, which the band does not hold
double RmsOf(const SceneAnswer& answer, sim::SensorTarget target) {
  if (answer.steady) {
    const sim::LinearModel model = sim::AssembleModel(EffectiveOf(answer).scene);
    return std::abs(answer.steady->phasors(sim::StateOf(model, target))) / std::numbers::sqrt2;
  }
  return answer.scene.drive.offset_v != 0 ? kNan : NumberOf(answer, KeyOf(Compared::kRms, target));
}

// of the skin, which is the body whose rise is known
dsp::Estimate RiseOf(const SceneAnswer& answer) {
  const auto played = PlayedMotion(answer);
  const MotionNumbers numbers = NumbersOf(answer, played ? &*played : nullptr);
  if (!numbers.rise || !numbers.rise->rise_s) return {kNan, 0};
  return {*numbers.rise->rise_s, numbers.rise->uncertainty_s};
}

sim::SensorTarget TargetOf(const sim::Scene& scene) {
  return scene.sensor ? scene.sensor->target : sim::SensorTarget::kSkin;
}

bool HasFrequency(const sim::Drive& drive) {
  return drive.kind == sim::DriveKind::kSine || drive.kind == sim::DriveKind::kBurst;
}

// a drive outside of the band leaves nothing in it
Result<void> CheckBand(const sim::Drive& drive, const MeasuredNumbers& measured,
                       const std::string& path) {
  const double f = drive.frequency_hz;
  if (!HasFrequency(drive) || (f >= measured.lower_hz && f <= measured.upper_hz)) return {};
  return CannotAnswer(path,
                      fmt::format("drives at {:g} Hz, outside of the {:g} to {:g} Hz that the "
                                  "measured RMS is of",
                                  f, measured.lower_hz, measured.upper_hz),
                      "analyze the trial with another --band, and give what --json prints");
}

// --- the command line ---

struct Words {
  std::vector<std::string> files, inputs, uncertainties;
  document::Outputs outputs;
};

void Declare(cli::Options& options, Words& words) {
  options.Positionals("files", &words.files,
                      "Trials or results of analyze --json, repeats of one measurement, and last "
                      "the scene.toml",
                      0);
  options.Repeated("--input", &words.inputs, "KEY=VALUE",
                   "A key of the scene whose value is uncertain: KEY=600+-50, KEY=600(50), or a "
                   "range KEY=600:1200");
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

document::Key KeyOf(Compared quantity, sim::SensorTarget target) {
  switch (quantity) {
    case Compared::kRms:
      if (target == sim::SensorTarget::kSkin) return document::kSkinRms;
      if (target == sim::SensorTarget::kCase) return kCaseRms;
      return document::Key{"mover_rms_m", "mover displacement (RMS)", document::kMetre};
    case Compared::kTone:
      return {document::kToneFrequency.name, "frequency of the tone", document::kHertz};
    case Compared::kRise:
      return document::kRise;
    case Compared::kCurrent:
      return document::kCurrentRms;
    case Compared::kPower:
      return document::kPower;
    case Compared::kPhase:
      break;
  }
  return document::kPhase;
}

Result<MeasuredNumbers> MeasuredIn(const std::string& text, const std::string& path) {
  Trials trials;
  HAPTOMETER_TRY(trials.AddDocument(text, path));
  return trials.Mean();
}

Result<MeasuredNumbers> ReadMeasured(std::span<const std::string> paths) {
  Trials trials;
  for (const std::string& path : paths) {
    HAPTOMETER_LET(const auto text, DocumentOf(path));
    HAPTOMETER_TRY(trials.AddDocument(text, path));
  }
  return trials.Mean();
}

Result<void> AddUncertainties(const std::vector<std::string>& words, sim::SensorTarget target,
                              MeasuredNumbers& measured) {
  HAPTOMETER_LET(const auto pairs, cli::ReadKeyValues(words, "--uncertainty"));
  for (const auto& [key, text] : pairs) {
    const std::string where = "--uncertainty " + key;
    std::size_t k = 0;
    while (k < kComparedCount && KeyOf(static_cast<Compared>(k), target).name != key) ++k;
    if (k == kComparedCount) {
      return Usage(where, "is no quantity that is compared", "write it like current_rms_a=1%");
    }
    if (!measured.numbers[k]) return CannotAnswer(where, "is not measured", "leave it out");
    dsp::Estimate& number = *measured.numbers[k];
    const bool is_share = text.ends_with('%');
    HAPTOMETER_LET(const auto u,
                   ParseQuantity(text.substr(0, text.size() - (is_share ? 1 : 0)),
                                 is_share ? Dimension::kNone : DimensionOfKey(key), where));
    if (!(u.value > 0)) return Usage(where, "must be above 0", "give a standard uncertainty");
    const double added = is_share ? u.value / 100 * std::abs(number.value) : u.value;
    number.uncertainty = std::hypot(number.uncertainty, added);
    measured.has_electrical_gain |= k >= static_cast<std::size_t>(Compared::kCurrent);
  }
  return {};
}

Result<std::vector<ComparedInput>> ReadInputs(const std::vector<std::string>& words) {
  HAPTOMETER_LET(const auto pairs, cli::ReadKeyValues(words, "--input"));
  std::vector<ComparedInput> inputs;
  inputs.reserve(pairs.size());
  for (const auto& [key, text] : pairs) {
    HAPTOMETER_LET(const auto value, ReadInput(key, text));
    inputs.push_back({.key = key, .value = value});
  }
  return inputs;
}

Result<ComparedScene> ComparedScene::Read(const std::string& path,
                                          std::vector<ComparedInput> inputs) {
  // an error of the file itself is told with its line
  HAPTOMETER_TRY(sim::ReadSceneFile(path));
  auto varied = sim::VariedScene::ReadFile(path, Mapped(inputs, &ComparedInput::key));
  if (!varied) {
    Error error = varied.error();
    if (error.where != path) error.where = "--input " + error.where;
    return std::unexpected(std::move(error));
  }
  ComparedScene scene(*std::move(varied), std::move(inputs));
  HAPTOMETER_LET(const auto stated,
                 scene.At(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(scene.inputs_.size()))));
  scene.target_ = TargetOf(stated);
  HAPTOMETER_TRY(scene.TakeActuator(stated.actuator_covariance, stated.actuator));
  return scene;
}

Result<void> ComparedScene::TakeActuator(const sim::ActuatorCovariance& covariance,
                                         const sim::Actuator& actuator) {
  for (std::size_t k = 0; k < covariance.size(); ++k) {
    if (covariance[k][k] == 0) continue;
    const double value = NumberOf(actuator, k);
    inputs_.push_back({.key = std::string(kActuatorKeys[k]),
                       .value = {value, value * std::sqrt(covariance[k][k])},
                       .symbol = k});
  }
  const auto count = static_cast<Eigen::Index>(inputs_.size());
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      const auto& one = inputs_[static_cast<std::size_t>(i)].symbol;
      const auto& other = inputs_[static_cast<std::size_t>(j)].symbol;
      if (!one || !other) continue;
      correlation(i, j) =
          covariance[*one][*other] / std::sqrt(covariance[*one][*one] * covariance[*other][*other]);
      correlation(j, i) = correlation(i, j);
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
    scene->actuator = sim::Scaled(scene->actuator, *inputs_[k].symbol,
                                  std::exp(step * value.standard_uncertainty / value.value));
  }
  return scene;
}

Result<SimulatedNumbers> SimulatedOf(const sim::Scene& scene, const std::string& where,
                                     bool with_rise) {
  HAPTOMETER_LET(const auto answer, AnswerScene(scene, where));
  const sim::SensorTarget target = TargetOf(scene);
  SimulatedNumbers numbers{};
  const auto set = [&](Compared quantity, dsp::Estimate number) {
    numbers[static_cast<std::size_t>(quantity)] = number;
  };
  set(Compared::kRms, {RmsOf(answer, target), 0});
  set(Compared::kTone, {HasFrequency(scene.drive) ? scene.drive.frequency_hz : kNan, 0});
  const bool has_rise = with_rise && target == sim::SensorTarget::kSkin;
  set(Compared::kRise, has_rise ? RiseOf(answer) : dsp::Estimate{kNan, 0});
  for (const Compared quantity : {Compared::kCurrent, Compared::kPower, Compared::kPhase}) {
    set(quantity, {NumberOf(answer, KeyOf(quantity, target)), 0});
  }
  return numbers;
}

Result<Propagation> Propagate(const ComparedScene& scene, const MeasuredNumbers& measured) {
  const bool with_rise = measured.numbers[static_cast<std::size_t>(Compared::kRise)].has_value();
  const auto count = static_cast<Eigen::Index>(scene.inputs().size());
  const auto numbers_at = [&](const Eigen::VectorXd& steps) -> Result<SimulatedNumbers> {
    HAPTOMETER_LET(const auto at, scene.At(steps));
    return SimulatedOf(at, scene.path(), with_rise);
  };
  HAPTOMETER_LET(const auto stated, scene.At(Eigen::VectorXd::Zero(count)));
  HAPTOMETER_TRY(CheckBand(stated.drive, measured, scene.path()));
  Propagation propagation{.changes = Eigen::MatrixXd(kComparedCount, count),
                          .curvature = Eigen::MatrixXd(kComparedCount, count)};
  HAPTOMETER_LET(propagation.at, SimulatedOf(stated, scene.path(), with_rise));
  for (Eigen::Index k = 0; k < count; ++k) {
    HAPTOMETER_LET(const auto above, numbers_at(scene.factor().col(k)));
    HAPTOMETER_LET(const auto below, numbers_at(-scene.factor().col(k)));
    for (std::size_t i = 0; i < kComparedCount; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      propagation.changes(row, k) = (above[i].value - below[i].value) / 2;
      propagation.curvature(row, k) =
          (above[i].value + below[i].value) / 2 - propagation.at[i].value;
    }
  }
  return propagation;
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
    HAPTOMETER_TRY(AddUncertainties(words.uncertainties, scene.target(), measured));
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
    // a difference ends as a question that is not answered does
    return cli::WorseStatus(status, result.Differs() ? ExitStatus(Cause::kCannotAnswer) : 0);
  };
  return document::RunVerb(kVerb, options, words.outputs, argc, argv, answer);
}

}  // namespace haptometer::tools
