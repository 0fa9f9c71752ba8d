#include "tools/cost/cost.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/band.h"
#include "base/jobs.h"
#include "base/mapped.h"
#include "sim/scene/scene_file.h"
#include "tools/acquire/advise_document.h"
#include "tools/cli/options.h"
#include "tools/cli/progress.h"
#include "tools/cli/shared_options.h"
#include "tools/document/present.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "cost";
constexpr std::string_view kDefaultScene = "the thesis's adapter scene";
constexpr double kDefaultSimulated = 1e-6;
constexpr double kDefaultMeasured = 0.01;
constexpr double kLargestMeasured = 0.25;

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Show what an accuracy costs: of measuring, of constants, of a simulation.",
    .examples = {"haptometer cost",
                 "haptometer cost skin-rms --scene fixtures/lra_adapter.toml --accuracy 1e-6",
                 "haptometer cost band-rms --sensor il-030 --rms 10um --accuracy 1%"}};

// what may be asked: a simulated quantity, a constant of an actuator, or a vibration's RMS
struct QuestionName {
  std::string_view name;
  bool is_recording = false;
  std::optional<Simulated> simulated{};
  std::optional<fit::Constant> constant{};
};

constexpr auto kQuestions = std::to_array<QuestionName>({
    {.name = "skin-rms", .simulated = Simulated::kSkinRms},
    {.name = "waveform", .simulated = Simulated::kWaveform},
    {.name = kBandRms, .is_recording = true},
    {.name = "kv", .constant = fit::Constant::kStiffness},
    {.name = "bv", .constant = fit::Constant::kDamping},
    {.name = "km", .constant = fit::Constant::kForceConstant},
});

struct Words {
  std::vector<std::string> question;
  std::optional<double> accuracy;
  std::string scene;
  std::string actuator;
  std::string sensor;
  AdviseWords vibration;  // RMS and drive
  std::string band;
  bool measure = false;
  document::Outputs outputs;
};

Result<void> TakeAccuracy(const std::string& text, std::optional<double>& accuracy) {
  HAPTOMETER_LET(accuracy, cli::ReadAccuracy(text, 0, 1));
  return {};
}

void Declare(cli::Options& options, Words& words) {
  options
      .Positionals("question", &words.question,
                   "skin-rms, waveform, band-rms, kv, bv or km; without one the whole chain", 0)
      .Known(Mapped<std::string>(kQuestions, &QuestionName::name))
      .is_repeated = false;
  options
      .Parsed(
          "--accuracy", "1e-6|1%",
          [&words](const std::string& text) { return TakeAccuracy(text, words.accuracy); },
          "Largest relative error of a simulation; else half the 95 % interval")
      .Default("1e-6 of a simulation, else 1%");
  options.Text("--scene", &words.scene, "SCENE.toml", "Scene of skin-rms and waveform")
      .Default(std::string(kDefaultScene));
  options.Text("--actuator", &words.actuator, "NAME|FILE.toml", "Actuator of kv, bv and km")
      .Default(std::string(kDefaultActuator))
      .Known({std::string(kDefaultActuator)});
  options.Text("--sensor", &words.sensor, "TEXT", "Of band-rms: routes whose name holds it");
  options
      .Number("--rms", &words.vibration.rms_m, Dimension::kLength, cli::Above(0),
              "Of band-rms: expected RMS")
      .Default("10um");
  options
      .Number("--drive", &words.vibration.drive_hz, Dimension::kFrequency, cli::Above(0),
              "Of band-rms: frequency of the drive")
      .Default("225Hz");
  options.Text("--band", &words.band, "20-500Hz", "Of band-rms: band of the RMS")
      .Default(std::string(kDefaultBand));
  options.Flag("--measure", &words.measure,
               "Measure here instead of predicting; without a question in 2 to 5 minutes");
  document::DeclareOutputs(options, words.outputs, {});
}

Result<const QuestionName*> QuestionOf(const std::vector<std::string>& words) {
  if (words.size() > 1) {
    return Usage(words[1], "is a second question", "ask one at a time");
  }
  const auto* const found = std::ranges::find(kQuestions, words.front(), &QuestionName::name);
  if (found != kQuestions.end()) return found;
  return Usage(words.front(), "is none of skin-rms, waveform, band-rms, kv, bv, km",
               "write haptometer cost skin-rms --scene FILE, or see haptometer cost --help");
}

// options that a question does not look at are refused
Result<void> CheckWords(const Words& words, const QuestionName* question) {
  const bool simulated = question != nullptr && question->simulated;
  const bool constant = question != nullptr && question->constant;
  return cli::CheckRules({
      {!words.scene.empty() && !simulated, "--scene", "is of skin-rms and waveform",
       "write haptometer cost skin-rms --scene FILE"},
      {!words.actuator.empty() && !constant, "--actuator", "is of kv, bv and km",
       "write haptometer cost km --actuator FILE"},
      {(!words.sensor.empty() || words.vibration.rms_m || words.vibration.drive_hz ||
        !words.band.empty()) &&
           !(question != nullptr && question->is_recording),
       "--sensor, --rms, --drive, --band", "are of band-rms",
       "write haptometer cost band-rms --rms 10um"},
      {words.accuracy && question == nullptr, "--accuracy", "is of a question",
       "write haptometer cost skin-rms --accuracy 1e-6"},
      {question != nullptr && !simulated && words.measure, "--measure",
       "measures simulations and the whole chain", "leave it out"},
      {question != nullptr && !simulated && words.accuracy > kLargestMeasured, "--accuracy",
       "is above 25 %", "no interval so wide is planned"},
      {simulated && words.accuracy.value_or(1) < sim::kLeastTolerance, "--accuracy",
       fmt::format("is below {:g}", sim::kLeastTolerance), "rounding is no smaller"},
  });
}

Result<CostAnswer> AnswerSimulation(const Words& words, Simulated what) {
  sim::Scene scene = LadderScene(SceneClass::kLinear).scene;
  const std::string where = words.scene.empty() ? std::string(kDefaultScene) : words.scene;
  if (!words.scene.empty()) {
    HAPTOMETER_LET(scene, sim::ReadSceneFile(words.scene));
  }
  scene.tolerance = words.accuracy.value_or(kDefaultSimulated);
  const bool is_waveform = what == Simulated::kWaveform;
  scene.quantity = is_waveform ? sim::AskedQuantity::kSkinWaveform : sim::AskedQuantity::kSkinRms;
  // a waveform has a length; an RMS is that of the scene, steady where it states none
  if (words.scene.empty() && !is_waveform) scene.duration_s.reset();
  if (is_waveform && !scene.duration_s) scene.duration_s = kLadderDurationS;
  return CostOfSimulation(scene, what, where, words.measure);
}

Result<CostAnswer> AnswerRecording(const Words& words) {
  // what is not stated is as RouteQuestion has it
  AdviseWords vibration = words.vibration;
  const RouteQuestion usual;
  if (!vibration.rms_m) vibration.rms_m = usual.rms_m;
  if (!vibration.drive_hz) vibration.drive_hz = usual.drive_hz;
  vibration.accuracy = fmt::format("{:.17g}", words.accuracy.value_or(kDefaultMeasured));
  const std::string band = words.band.empty() ? std::string(kDefaultBand) : words.band;
  HAPTOMETER_LET(const auto question, ReadRouteQuestion(vibration, band));
  return CostOfRecording(question, words.sensor);
}

Result<CostAnswer> AnswerQuestion(const Words& words, const QuestionName& question) {
  if (question.is_recording) return AnswerRecording(words);
  if (question.simulated) return AnswerSimulation(words, *question.simulated);
  return CostOfConstant(*question.constant,
                        words.actuator.empty() ? std::string(kDefaultActuator) : words.actuator,
                        words.accuracy.value_or(kDefaultMeasured));
}

// rungs that are measured here, where that is asked for
std::vector<Rung> Measured(const Words& words) {
  if (!words.measure) return {};
  cli::WorkProgress progress(kVerb, "without --measure it answers at once");
  const WatchedWork watched(
      [&](std::string_view what, double share) { progress.Update(what, share); });
  return MeasureRungs();
}

}  // namespace

int RunCost(int argc, const char* const* argv) {
  cli::Options options(kText);
  Words words;
  Declare(options, words);
  const auto answer = [&]() -> Result<int> {
    const QuestionName* question = nullptr;
    if (!words.question.empty()) {
      HAPTOMETER_LET(question, QuestionOf(words.question));
    }
    HAPTOMETER_TRY(CheckWords(words, question));
    if (question == nullptr) {
      HAPTOMETER_LET(const auto chain, CostOfChain(Measured(words)));
      return document::Present(ChainDocument(chain), words.outputs, argc, argv);
    }
    HAPTOMETER_LET(const auto cost, AnswerQuestion(words, *question));
    return document::Present(CostDocument(cost), words.outputs, argc, argv);
  };
  return document::RunVerb(kVerb, options, words.outputs, argc, argv, answer);
}

}  // namespace haptometer::tools
