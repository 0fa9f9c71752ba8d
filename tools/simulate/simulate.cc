#include <fmt/core.h>

#include <algorithm>
#include <cmath>
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
#include "tools/plot/gnuplot.h"
#include "tools/simulate/scene_answer.h"
#include "tools/simulate/simulate_document.h"
#include "tools/simulate/simulated_trial.h"
#include "tools/simulate/waveforms.h"
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
  std::string waveforms;
  std::optional<Quantity> rate_hz;
  std::string plot;
};

void Declare(cli::Options& options, SimulateOptions& wanted) {
  options.Positional("scene", &wanted.scene_path, "A scene.toml (docs/reference/scene.md)");
  options.Number("--duration", &wanted.duration_s, Dimension::kTime,
                 "Length of the run; beats [run] duration_s");
  options.Flag("--explain", &wanted.explain,
               "Tell of each effect whether it is on, why, and what it changes and costs");
  options.Number("--tolerance", &wanted.tolerance, Dimension::kNone,
                 "Relative change that effects = \"auto\" may neglect; beats [run] tolerance");
  options.Choice("--quantity", &wanted.quantity,
                 {sim::kAskedQuantityNames.begin(), sim::kAskedQuantityNames.end()},
                 "What the tolerance is about; beats [run] quantity");
  options.Output("-o,--output", &wanted.output, "FILE", "Write what the scene's sensor sees");
  options.Output("--waveforms", &wanted.waveforms, "FILE",
                 "Write the exact motion, voltage, current and force over time, .csv, .h5 or .bin");
  options.Number("--rate", &wanted.rate_hz, Dimension::kFrequency,
                 "Rows a second of --waveforms; 64 in the shortest period");
  options.Output("--plot", &wanted.plot, "FILE", "Draw waveforms and spectrum, .svg, .png or .pdf");
  options.Flag("--overwrite", &wanted.overwrite, "Replace FILE where it exists");
}

// How long files last; of a scene without a duration that is said.
double LengthOfFiles(const sim::Scene& scene, std::string_view what) {
  if (!scene.duration_s) {
    cli::Remark(kVerb, fmt::format("no duration: {} {:g} s", what, kDefaultTrialS));
  }
  return scene.duration_s.value_or(kDefaultTrialS);
}

// Fills in what a trial needs and the scene does not say, and says so.
Result<void> Record(const SimulateOptions& wanted, sim::Scene scene) {
  if (!scene.sensor) {
    scene.sensor = sim::IdealSensor();
    cli::Remark(kVerb, "no [sensor]: an ideal one on the skin at 10 kHz is assumed");
  }
  const double duration_s = LengthOfFiles(scene, "the trial lasts");
  const double rows = duration_s * scene.sensor->rate_hz;
  if (rows < 1 || rows > kMostRows) {
    return Usage(wanted.output,
                 fmt::format("{:g} s at {:g} Hz are {:.3g} readings", duration_s,
                             scene.sensor->rate_hz, std::floor(rows)),
                 fmt::format("give a --duration for 1 to {:g}", kMostRows));
  }
  trial::Record record = sim::SimulateRecord(scene, duration_s);
  record.metadata.fields["scene"] = Printable(wanted.scene_path);
  return WriteSimulatedTrial(wanted.output, record, wanted.overwrite);
}

// A drive that ends is played until its motion has rung down.
Result<void> AddDuration(const std::string& where, sim::Scene& scene) {
  if (scene.duration_s || sim::IsLasting(scene.drive)) return {};
  const auto ring_down_s = sim::RingDownS(scene);
  if (!ring_down_s) {
    return CannotAnswer(where, "has no duration, and a motion that never dies away",
                        "give duration_s in [run], or --duration");
  }
  const double end_s = sim::EndOfDriveS(scene.drive);
  // whole milliseconds, where many drives' pieces and outputs meet
  const double rung_down_s = std::ceil((end_s + *ring_down_s) * 1e3) / 1e3;
  scene.duration_s = std::min(rung_down_s, sim::kLongestRunS);
  cli::Remark(kVerb, fmt::format("no duration: {:g} s, the drive's {:.4g} s and {:.4g} s in which "
                                 "the slowest motion falls to a thousandth",
                                 *scene.duration_s, end_s, *ring_down_s));
  return {};
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

// The motion as a file and a picture want it, where they do.
Result<void> DrawAndWrite(const SimulateOptions& wanted, SimulateAnswer& answer) {
  if (wanted.waveforms.empty() && wanted.plot.empty()) return {};
  const sim::EffectiveScene effective = EffectiveOf(answer.solved);
  const double own_hz = effective.RateHz();
  const double rate_hz = wanted.rate_hz ? wanted.rate_hz->value : own_hz;
  const double duration_s = LengthOfFiles(answer.solved.scene, "waveforms last");
  const double rows = duration_s * std::max(rate_hz, wanted.plot.empty() ? 0 : own_hz);
  if (!(rows >= 1 && rows <= kMostWaveformRows)) {
    return Usage(wanted.waveforms.empty() ? "--plot" : "--waveforms",
                 fmt::format("{:g} s at {:g} Hz are {:.3g} rows", duration_s, rate_hz, rows),
                 fmt::format("give a --duration or --rate for 1 to {:g}", kMostWaveformRows));
  }
  const sim::Beginning start = StartOf(answer.solved, effective);
  const sim::Waveforms waves = sim::PlayWaveforms(effective, start, duration_s, rate_hz);
  if (waves.stalled_at_s) {
    cli::Remark(kVerb,
                fmt::format("waveforms end at {:.9g} s: events without end", *waves.stalled_at_s));
  }
  if (!wanted.waveforms.empty()) {
    const trial::Record record = RecordOf(waves, answer.solved.scene, wanted.scene_path);
    if (auto done = WriteWaveforms(wanted.waveforms, record, wanted.overwrite); !done) return done;
    answer.waveforms_path = wanted.waveforms;
  }
  if (wanted.plot.empty()) return {};
  const bool is_own = rate_hz == own_hz;
  const auto panels = WaveformPanels(
      is_own ? waves : sim::PlayWaveforms(effective, start, duration_s, own_hz), effective.scene);
  if (!panels) return std::unexpected(panels.error());
  answer.plot_path = wanted.plot;
  return plot::DrawPanels(wanted.plot, *panels);
}

// The motion over the scene's duration, or over some periods of what it settles to; nothing where
// that is not asked about or too long.
std::optional<sim::Waveforms> Played(const SceneAnswer& solved) {
  constexpr double kPlayedPeriods = 8;
  if (!solved.scene.duration_s && SettledRun(solved) == nullptr) return std::nullopt;
  const sim::EffectiveScene effective = EffectiveOf(solved);
  const double rate_hz = effective.RateHz();
  const double duration_s =
      solved.scene.duration_s.value_or(kPlayedPeriods / effective.scene.drive.frequency_hz);
  if (!(duration_s * rate_hz >= 1 && duration_s * rate_hz <= kMostWaveformRows)) {
    return std::nullopt;
  }
  return sim::PlayWaveforms(effective, StartOf(solved, effective), duration_s, rate_hz, true);
}

// what is asked for must be possible before the work
Result<void> CheckFiles(const SimulateOptions& wanted) {
  if (!wanted.plot.empty()) {
    if (auto check = plot::CheckPlotPath(wanted.plot); !check) return check;
  }
  if (!wanted.output.empty()) {
    auto check = cli::CheckOutput(wanted.output, cli::kTrialOutput, wanted.overwrite);
    if (!check) return check;
  }
  if (wanted.waveforms.empty()) {
    if (!wanted.rate_hz) return {};
    return Usage("--rate", "is of --waveforms, which are not asked for", "add --waveforms FILE");
  }
  if (wanted.rate_hz && !(wanted.rate_hz->value > 0)) {
    return Usage("--rate", fmt::format("{:g} Hz is no rate", wanted.rate_hz->value),
                 "give rows a second");
  }
  return CheckWaveformPath(wanted.waveforms, wanted.overwrite);
}

Result<SimulateAnswer> Answer(const SimulateOptions& wanted) {
  if (auto check = CheckFiles(wanted); !check) return std::unexpected(check.error());
  auto scene = ReadScene(wanted);
  if (!scene) return std::unexpected(scene.error());
  RemarkIdleConstants(*scene);
  if (auto added = AddDuration(wanted.scene_path, *scene); !added) {
    return std::unexpected(added.error());
  }
  const auto solved = [&] {
    cli::WorkProgress progress(kVerb, scene->duration_s ? "a shorter --duration takes less"
                                                        : "--duration 0.1s plays a run instead");
    const WatchedWork watched(
        [&](std::string_view what, double share) { progress.Update(what, share); });
    return AnswerScene(*scene, wanted.scene_path);
  }();
  if (!solved) return std::unexpected(solved.error());
  const bool is_sine = scene->drive.kind == sim::DriveKind::kSine;
  if (is_sine && scene->duration_s && !solved->window) {
    cli::Remark(kVerb, fmt::format("{:g} s are less than ten periods, so there is no window RMS",
                                   *scene->duration_s));
  }
  const auto played = Played(*solved);
  SimulateAnswer answer{.scene_path = wanted.scene_path,
                        .solved = *solved,
                        .numbers = NumbersOf(*solved, played ? &*played : nullptr),
                        .trial_path = {},
                        .explanation = {}};
  if (wanted.explain) {
    auto explanation = Explanation(*solved, wanted.scene_path);
    if (!explanation) return std::unexpected(explanation.error());
    answer.explanation = std::move(*explanation);
  }
  if (auto done = DrawAndWrite(wanted, answer); !done) return std::unexpected(done.error());
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
  cli::Print(options.json() ? SimulateJson(*answer) : SimulateText(*answer));
  return 0;
}

}  // namespace haptometer::tools
