#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "base/jobs.h"
#include "base/text.h"
#include "sim/effective_scene.h"
#include "sim/scene/scene_file.h"
#include "sim/sensor_model.h"
#include "sim/waveforms.h"
#include "tools/cli/options.h"
#include "tools/cli/output_file.h"
#include "tools/cli/progress.h"
#include "tools/cli/terminal.h"
#include "tools/document/present.h"
#include "tools/simulate/accuracy_option.h"
#include "tools/simulate/scene_answer.h"
#include "tools/simulate/simulate_document.h"
#include "tools/simulate/simulated_trial.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "simulate";
// length of files of a scene without a duration, s
constexpr double kDefaultFileS = 1;
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
  std::optional<double> duration_s;
  AccuracyWords accuracy;
  std::string quantity;
  bool explain = false;
  std::string waveforms;
  std::optional<double> rate_hz;
  document::Outputs outputs;
  std::vector<std::string> command;
};

void Declare(cli::Options& options, SimulateOptions& wanted) {
  options.Positional("scene", &wanted.scene_path, "A scene.toml (docs/reference/scene.md)");
  options.Number("--duration", &wanted.duration_s, Dimension::kTime,
                 {.least = 0, .most = sim::kLongestRunS, .is_above = true},
                 "Length of the run; overrides [run] duration_s");
  options.Flag(
      "--explain", &wanted.explain,
      "Show for each effect whether it is on, why and what it changes, and what an accuracy costs");
  DeclareAccuracy(options, wanted.accuracy);
  options.Choice("--quantity", &wanted.quantity,
                 {sim::kAskedQuantityNames.begin(), sim::kAskedQuantityNames.end()},
                 "Quantity whose changes --explain shows; overrides [run] quantity");
  options.Output("-o,--output", &wanted.output, "FILE",
                 "Write the readings of the scene's sensor as a trial");
  options.Output("--waveforms", &wanted.waveforms, "FILE.csv|h5|bin",
                 "Write the exact motion, voltage, current and force over time");
  options
      .Number("--rate", &wanted.rate_hz, Dimension::kFrequency, cli::Above(0),
              "Rows per second of --waveforms")
      .Default("64 in the shortest period");
  options.Flag("--all", &wanted.outputs.all, "Print the whole run and the method too");
  options.Output("--plot", &wanted.outputs.plot, "FILE.svg|png|pdf", "Draw waveforms and spectrum");
  options.Output("--report", &wanted.outputs.report, "FILE.html",
                 "Write one page with figures, numbers and assumptions");
  options.Flag("--overwrite", &wanted.overwrite, "Replace FILE where it exists");
}

// length of files in s; a scene without a duration gets a note
double LengthOfFiles(const sim::Scene& scene, Findings<SimulateFinding>& findings) {
  if (!scene.duration_s && !findings.Has(SimulateFinding::kDurationAssumed)) {
    findings.Note(SimulateFinding::kDurationAssumed, {{"duration_s", kDefaultFileS}});
  }
  return scene.duration_s.value_or(kDefaultFileS);
}

// writes the readings of the scene's sensor, an ideal one where it has none
Result<void> Record(const SimulateOptions& wanted, sim::Scene scene,
                    Findings<SimulateFinding>& findings) {
  if (!scene.sensor) {
    scene.sensor = sim::IdealSensor();
    findings.Note(SimulateFinding::kIdealSensor, {{"rate_hz", scene.sensor->rate_hz}});
  }
  const double duration_s = LengthOfFiles(scene, findings);
  // number of readings: at least one, and few enough for the memory
  const double rows = duration_s * scene.sensor->rate_hz;
  if (rows < 1 || rows > kMostRows) {
    return Usage(wanted.output,
                 fmt::format("{:g} s at {:g} Hz are {:.3g} readings", duration_s,
                             scene.sensor->rate_hz, std::floor(rows)),
                 fmt::format("give a --duration for 1 to {:g}", kMostRows));
  }
  trial::Record record = sim::SimulateRecord(scene, duration_s);
  record.metadata.fields["scene"] = Printable(wanted.scene_path);
  AddProvenance(document::CollectProvenance(wanted.command), record.metadata);
  return WriteSimulatedTrial(wanted.output, record, wanted.overwrite);
}

// a drive that ends is run until its motion has decayed to a thousandth
Result<void> AddDuration(const std::string& where, sim::Scene& scene,
                         Findings<SimulateFinding>& findings) {
  // lasting drives (sine, tones) have a steady state and need no duration
  if (scene.duration_s || sim::IsLasting(scene.drive)) return {};
  const auto ring_down_s = sim::RingDownS(scene);
  if (!ring_down_s) {
    return CannotAnswer(where, "has no duration, and its motion does not decay",
                        "give duration_s in [run], or --duration");
  }
  // end of the drive plus the time in which the slowest motion decays
  const double end_s = sim::EndOfDriveS(scene.drive);
  // whole milliseconds: at these, pieces of many drives end on an output
  const double rung_down_s = std::ceil((end_s + *ring_down_s) * 1e3) / 1e3;
  scene.duration_s = std::min(rung_down_s, sim::kLongestRunS);
  findings.Note(
      SimulateFinding::kDurationOfDrive,
      {{"duration_s", *scene.duration_s}, {"drive_s", end_s}, {"ring_down_s", *ring_down_s}});
  return {};
}

// the scene with the options of the command line, which override it
Result<sim::Scene> ReadScene(const SimulateOptions& wanted) {
  HAPTOMETER_LET(auto scene, sim::ReadSceneFile(wanted.scene_path));
  if (!wanted.quantity.empty()) {
    const auto* const place = std::ranges::find(sim::kAskedQuantityNames, wanted.quantity);
    scene.quantity = static_cast<sim::AskedQuantity>(place - sim::kAskedQuantityNames.begin());
  }
  scene.tolerance = wanted.accuracy.Asked().value_or(scene.tolerance);
  if (wanted.duration_s) scene.duration_s = wanted.duration_s;
  return scene;
}

// effects of the scene, each forced on and off; also for a scene that names none
Result<Explanation> Explained(const SceneAnswer& solved, const std::string& where) {
  HAPTOMETER_LET(auto choice, solved.effects ? Result<sim::EffectChoice>(*solved.effects)
                                             : DecideEffects(solved.scene, where));
  std::vector<EffectTrial> trials = TryEffects(solved.scene, choice);
  // what no bound shows is measured here
  for (const EffectTrial& trial : trials) {
    sim::EffectVerdict& verdict = choice.verdicts[sim::PlaceOf(trial.effect)];
    if (verdict.ground == sim::Ground::kKept) verdict.change = trial.change;
  }
  return Explanation{.choice = std::move(choice),
                     .trials = std::move(trials),
                     .accuracies = TryAccuracies(solved.scene, where)};
}

// the motion over time for the waveforms' file and the figures, where one of them is requested
Result<void> AddWaveforms(const SimulateOptions& wanted, SimulateAnswer& answer) {
  const bool has_figures = wanted.outputs.HasFigures();
  if (wanted.waveforms.empty() && !has_figures) return {};
  const sim::EffectiveScene effective = EffectiveOf(answer.solved);
  const double own_hz = effective.RateHz();
  const double rate_hz = wanted.rate_hz.value_or(own_hz);
  const double duration_s = LengthOfFiles(answer.solved.scene, answer.findings);
  // rows of the file and of the figures, which have a rate of their own
  const double rows = duration_s * std::max(rate_hz, has_figures ? own_hz : 0);
  if (!(rows >= 1 && rows <= kMostWaveformRows)) {
    const std::string figures = wanted.outputs.plot.empty() ? "--report" : "--plot";
    return Usage(wanted.waveforms.empty() ? figures : "--waveforms",
                 fmt::format("{:g} s at {:g} Hz are {:.3g} rows", duration_s, rate_hz, rows),
                 fmt::format("give a --duration or --rate for 1 to {:g}", kMostWaveformRows));
  }
  const sim::Beginning start = StartOf(answer.solved, effective);
  // exact motion at uniform times, from the start that the answer has
  const sim::Waveforms waves = sim::PlayWaveforms(effective, start, duration_s, rate_hz);
  if (waves.stalled_at_s) {
    answer.findings.Doubt(SimulateFinding::kWaveformsStalled, {{"at_s", *waves.stalled_at_s}});
  }
  if (!wanted.waveforms.empty()) {
    trial::Record record = RecordOf(waves, answer.solved.scene, wanted.scene_path);
    AddProvenance(document::CollectProvenance(wanted.command), record.metadata);
    HAPTOMETER_TRY(WriteWaveforms(wanted.waveforms, record, wanted.overwrite));
    answer.waveforms_path = wanted.waveforms;
  }
  if (!has_figures) return {};
  // figures have the scene's own rate; a file with that rate is not computed twice
  const bool is_own = rate_hz == own_hz;
  HAPTOMETER_LET(
      answer.panels,
      WaveformPanels(is_own ? waves : sim::PlayWaveforms(effective, start, duration_s, own_hz),
                     effective.scene));
  answer.plot_path = wanted.outputs.plot;
  return {};
}

// outputs are checked before the computation
Result<void> CheckFiles(const SimulateOptions& wanted) {
  HAPTOMETER_TRY(document::CheckOutputs(wanted.outputs));
  if (!wanted.output.empty()) {
    HAPTOMETER_TRY(cli::CheckOutput(wanted.output, cli::kTrialOutput, wanted.overwrite));
  }
  const document::Outputs& outputs = wanted.outputs;
  const bool writes = !wanted.output.empty() || !wanted.waveforms.empty() ||
                      !outputs.plot.empty() || !outputs.report.empty();
  HAPTOMETER_TRY(cli::CheckRules({
      {!wanted.quantity.empty() && !wanted.explain, "--quantity",
       "applies to --explain only, which is not given", "add --explain"},
      {wanted.overwrite && !writes, "--overwrite",
       "applies to files that are written, of which none is given",
       "add -o FILE or --waveforms FILE"},
      {wanted.rate_hz && wanted.waveforms.empty(), "--rate",
       "applies to --waveforms only, which is not given", "add --waveforms FILE"},
  }));
  if (wanted.waveforms.empty()) return {};
  return CheckWaveformPath(wanted.waveforms, wanted.overwrite);
}

Result<SceneAnswer> Solve(const sim::Scene& scene, const std::string& where) {
  cli::WorkProgress progress(kVerb, scene.duration_s ? "a shorter --duration takes less"
                                                     : "--duration 0.1s plays a run instead");
  const WatchedWork watched(
      [&](std::string_view what, double share) { progress.Update(what, share); });
  return AnswerScene(scene, where);
}

Result<SimulateAnswer> Answer(const SimulateOptions& wanted) {
  HAPTOMETER_TRY(CheckFiles(wanted));
  HAPTOMETER_LET(auto scene, ReadScene(wanted));
  SimulateAnswer answer{.scene_path = wanted.scene_path};
  // before the solution: the duration is part of the scene
  HAPTOMETER_TRY(AddDuration(wanted.scene_path, scene, answer.findings));
  HAPTOMETER_LET(answer.solved, Solve(scene, wanted.scene_path));
  // least force and rise are taken from the played motion
  const auto played = PlayedMotion(answer.solved);
  answer.numbers = NumbersOf(answer.solved, played ? &*played : nullptr);
  if (wanted.explain) {
    HAPTOMETER_LET(answer.explanation, Explained(answer.solved, wanted.scene_path));
  }
  HAPTOMETER_TRY(AddWaveforms(wanted, answer));
  if (wanted.output.empty()) return answer;
  HAPTOMETER_TRY(Record(wanted, scene, answer.findings));
  answer.trial_path = wanted.output;
  return answer;
}

}  // namespace

int RunSimulate(int argc, const char* const* argv) {
  cli::Options options(kText);
  SimulateOptions wanted;
  Declare(options, wanted);
  if (const auto status = options.Parse(argc, argv)) return *status;
  wanted.command = {"haptometer", std::string(kVerb)};
  wanted.command.insert(wanted.command.end(), argv + std::min(argc, 1), argv + argc);
  const auto answer = Answer(wanted);
  if (!answer) return cli::ReportError(kVerb, answer.error());
  wanted.outputs.json = options.json();
  return document::Present(SimulateDocument(*answer), wanted.outputs, argc, argv);
}

}  // namespace haptometer::tools
