#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "sim/scene_file.h"
#include "sim/sensor_model.h"
#include "tools/cli/options.h"
#include "tools/cli/report.h"
#include "tools/simulate/effect_lines.h"
#include "tools/simulate/scene_answer.h"
#include "tools/simulate/simulate_output.h"
#include "tools/simulated_trial.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "simulate";
constexpr double kDefaultTrialS = 1;
constexpr double kMostRows = 5e7;  // of a simulated trial: half a gigabyte in memory

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Solve a scene of actuator, adapter and skin exactly.",
    .examples = {"haptometer simulate fixtures/lra_adapter.toml",
                 "haptometer simulate fixtures/lra_adapter.toml --duration 0.1s --json",
                 "haptometer simulate fixtures/lra_cone.toml --duration 3s -o trial.bin"}};

struct SimulateOptions {
  std::string scene_path;
  std::string output;
  bool overwrite = false;
  std::optional<Quantity> duration_s;
  std::optional<Quantity> tolerance;
  std::string quantity;
  bool explain = false;
};

void Declare(cli::Options& options, SimulateOptions& wanted) {
  options.Positional("scene", &wanted.scene_path, "A scene.toml (docs/notation.md)");
  options.Number("--duration", &wanted.duration_s, Dimension::kTime,
                 "Length of the run; beats [run] duration_s");
  options.Flag("--explain", &wanted.explain,
               "Tell of each effect whether it is on, why, and what it changes and costs");
  options.Number("--tolerance", &wanted.tolerance, Dimension::kNone,
                 "Relative change that effects = \"auto\" may neglect; beats [run] tolerance");
  options.Choice("--quantity", &wanted.quantity,
                 {sim::kAskedQuantityNames.begin(), sim::kAskedQuantityNames.end()},
                 "What the tolerance is about; beats [run] quantity");
  options.Text("-o,--output", &wanted.output, "FILE", "Write what the scene's sensor sees");
  options.Flag("--overwrite", &wanted.overwrite, "Replace FILE where it exists");
}

// Fills in what a trial needs and the scene does not say, and says so.
Result<void> Record(const SimulateOptions& wanted, sim::Scene scene) {
  if (!scene.sensor) {
    scene.sensor = sim::IdealSensor();
    cli::Remark(kVerb, "no [sensor]: an ideal one on the skin at 10 kHz is assumed");
  }
  if (!scene.duration_s) {
    cli::Remark(kVerb, fmt::format("no duration: the trial lasts {:g} s", kDefaultTrialS));
  }
  const double duration_s = scene.duration_s.value_or(kDefaultTrialS);
  const double rows = duration_s * scene.sensor->rate_hz;
  if (rows < 1 || rows > kMostRows) {
    return Usage(wanted.output,
                 fmt::format("{:g} s at {:g} Hz are {:.3g} readings", duration_s,
                             scene.sensor->rate_hz, std::floor(rows)),
                 fmt::format("give a --duration for 1 to {:g}", kMostRows));
  }
  trial::Record record = sim::SimulateRecord(scene, duration_s);
  record.metadata.fields["scene"] = wanted.scene_path;
  return WriteSimulatedTrial(wanted.output, record, wanted.overwrite);
}

// The scene with what the command line says over it.
Result<sim::Scene> ReadScene(const SimulateOptions& wanted) {
  auto scene = sim::ReadSceneFile(wanted.scene_path);
  if (!scene) return scene;
  if (!wanted.quantity.empty()) {
    const auto* const place = std::ranges::find(sim::kAskedQuantityNames, wanted.quantity);
    scene->quantity = static_cast<sim::AskedQuantity>(place - sim::kAskedQuantityNames.begin());
  }
  if (wanted.tolerance) {
    scene->tolerance = wanted.tolerance->value;
    if (!(scene->tolerance >= sim::kLeastTolerance && scene->tolerance < 1)) {
      return Usage("--tolerance",
                   fmt::format("{:g} is not {:g} or more and below 1", scene->tolerance,
                               sim::kLeastTolerance),
                   "it is relative: 1e-3 asks for three digits");
    }
  }
  if (!wanted.duration_s) return scene;
  const double duration_s = wanted.duration_s->value;
  if (!(duration_s > 0 && duration_s <= sim::kLongestRunS)) {
    return Usage("--duration", fmt::format("{:g} s is not between 0 and 1e6 s", duration_s),
                 "give the length of the run");
  }
  scene->duration_s = duration_s;
  return scene;
}

// also of a scene that names no effects
Result<std::string> Explanation(const SceneAnswer& solved, const std::string& where) {
  const sim::Scene& scene = solved.scene;
  Result<sim::EffectChoice> choice = sim::EffectChoice{};
  if (solved.effects) {
    choice = *solved.effects;
  } else {
    choice = DecideEffects(scene, where);
  }
  if (!choice) return std::unexpected(choice.error());
  return ExplainText(scene, *choice, TryEffects(scene, *choice));
}

// constants of effects that the scene does not call for are no mistake, but may be one
void RemarkIdleConstants(const sim::Scene& scene) {
  const sim::Effects& effects = scene.effects;
  if (effects.travel_stops && effects[sim::Effect::kTravelStops] == sim::Wish::kOff) {
    cli::Remark(kVerb, "[travel_stops] are stated and off: travel_stops = true in [effects]");
  }
  if (effects.contact_loss && effects[sim::Effect::kContactLoss] == sim::Wish::kOff) {
    cli::Remark(kVerb, "preload_n is stated and contact cannot break: contact = \"unilateral\"");
  }
}

Result<SimulateAnswer> Answer(const SimulateOptions& wanted) {
  const auto scene = ReadScene(wanted);
  if (!scene) return std::unexpected(scene.error());
  RemarkIdleConstants(*scene);
  const auto solved = AnswerScene(*scene, wanted.scene_path);
  if (!solved) return std::unexpected(solved.error());
  if (scene->duration_s && !solved->window) {
    cli::Remark(kVerb, fmt::format("{:g} s are less than ten periods, so there is no window RMS",
                                   *scene->duration_s));
  }
  SimulateAnswer answer{
      .scene_path = wanted.scene_path, .solved = *solved, .trial_path = {}, .explanation = {}};
  if (wanted.explain) {
    auto explanation = Explanation(*solved, wanted.scene_path);
    if (!explanation) return std::unexpected(explanation.error());
    answer.explanation = std::move(*explanation);
  }
  if (wanted.output.empty()) return answer;
  if (auto written = Record(wanted, *scene); !written) return std::unexpected(written.error());
  answer.trial_path = wanted.output;
  return answer;
}

}  // namespace

int RunSimulate(int argc, const char* const* argv) {
  cli::Options options(kText);
  SimulateOptions wanted;
  Declare(options, wanted);
  if (const auto status = options.Parse(argc, argv)) return *status;
  if (wanted.explain && options.json()) {
    const auto refusal = Usage("--explain", "prints a table for people",
                               "--json alone has each effect's decision and its ground");
    return cli::ReportError(kVerb, refusal.error());
  }
  const auto answer = Answer(wanted);
  if (!answer) return cli::ReportError(kVerb, answer.error());
  fmt::print("{}", options.json() ? SimulateJson(*answer) : SimulateText(*answer));
  return 0;
}

}  // namespace haptometer::tools
