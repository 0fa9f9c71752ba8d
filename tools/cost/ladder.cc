#include "tools/cost/ladder.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>

#include "base/error.h"
#include "base/text.h"
#include "sim/piecewise/piecewise_motion.h"
#include "sim/smooth/smooth_motion.h"
#include "tools/cli/csv_cell.h"
#include "tools/reproduce/thesis_model.h"

namespace haptometer::tools {

extern const std::string_view kSimulationLadders;  // docs/sim_cost.csv

namespace {

constexpr std::array<std::string_view, kSceneClasses> kNames{"linear", "stops", "contact",
                                                             "smooth"};
constexpr double kProbeTolerance = 1e-6;
constexpr std::string_view kProbeSetting = "1e-6";
constexpr double kProbeS = 0.2;

// The rungs of the shipped table; none of the effects' rows, of a method that failed, and of runs
// with other outputs.
std::vector<Rung> ReadRungs() {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  std::vector<Rung> rungs;
  std::vector<std::string> names;  // of the columns
  std::istringstream table{std::string(kSimulationLadders)};
  for (std::string line; std::getline(table, line);) {
    if (line.empty() || line.front() == '#') continue;
    const auto cells = cli::CellsOf(line);
    if (names.empty()) {
      names = cells;
      continue;
    }
    const auto cell = [&](std::string_view column) -> const std::string& {
      return cells.at(static_cast<std::size_t>(std::ranges::find(names, column) - names.begin()));
    };
    const auto* const name = std::ranges::find(kNames, cell("scene"));
    const auto rms_error = NumberFrom<double>(cell("rms_error"));
    const auto microseconds = NumberFrom<double>(cell("microseconds"));
    if (name == kNames.end() || !rms_error || !microseconds) continue;
    if (cell("setting").ends_with("outputs")) continue;
    rungs.push_back({.scene_class = static_cast<SceneClass>(name - kNames.begin()),
                     .method = cell("method"),
                     .setting = cell("setting"),
                     .seconds = 1e-6 * *microseconds,
                     .rms_error = *rms_error,
                     .worst_error = NumberFrom<double>(cell("worst_error")).value_or(kUnknown)});
  }
  return rungs;
}

// plays all outputs of a motion
template <typename Motion>
void Play(Motion motion) {
  constexpr auto kOutputs = static_cast<int>(kLadderDurationS * kLadderRateHz);
  for (int k = 0; k < kOutputs; ++k) motion.Next();
}

// plays the run of a class once with the method of the ladders; returns seconds
double TimeOfRun(SceneClass scene_class, double tolerance) {
  const sim::EffectiveScene ladder = LadderScene(scene_class);
  const auto begin = std::chrono::steady_clock::now();
  if (scene_class == SceneClass::kSmooth) {
    Play(sim::SmoothMotion(sim::AssembleSmooth(ladder.scene, ladder.piecewise, ladder.smooth),
                           ladder.scene.drive, sim::PiecewiseStartOf(ladder.scene),
                           {.rate_hz = kLadderRateHz}, {.tolerance = tolerance}));
  } else {
    Play(sim::PiecewiseMotion(sim::AssemblePiecewise(ladder.scene, ladder.piecewise),
                              ladder.scene.drive, sim::PiecewiseStartOf(ladder.scene),
                              {.rate_hz = kLadderRateHz}));
  }
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

std::string_view NameOf(SceneClass scene_class) {
  return kNames[static_cast<std::size_t>(scene_class)];
}

sim::EffectiveScene LadderScene(SceneClass scene_class) {
  const ThesisModel model;
  sim::EffectiveScene ladder{.scene = WithAdapter(model, kSimulatedConeAreaM2), .piecewise = {}};
  ladder.scene.start = sim::Start::kRest;
  ladder.scene.duration_s = kLadderDurationS;
  ladder.outputs_rate_hz = kLadderRateHz;
  switch (scene_class) {
    case SceneClass::kLinear:
      break;
    case SceneClass::kStops:
      ladder.piecewise.stops =
          sim::TravelStops{.gap_up_m = 0.3e-3, .gap_down_m = 0.3e-3, .restitution = 0.5};
      break;
    case SceneClass::kContact:
      ladder.piecewise.contact_loss = sim::ContactLoss{0.07};
      break;
    case SceneClass::kSmooth:
      ladder.smooth.spring = sim::StiffeningSpring{.cubic_n_per_m3 = 3e9};
      ladder.smooth.heating =
          sim::CoilHeating{.heat_capacity_j_per_k = 1e-3, .thermal_resistance_k_per_w = 100};
      break;
  }
  return ladder;
}

const std::vector<Rung>& ShippedRungs() {
  static const std::vector<Rung> kRungs = ReadRungs();
  return kRungs;
}

bool IsOwn(std::string_view method) {
  return method == "phasor" || method == "SmoothMotion" || method.starts_with("exact ");
}

double ErrorOf(const Rung& rung, Simulated what) {
  return what == Simulated::kSkinRms ? rung.rms_error : rung.worst_error;
}

const Rung* CheapestRung(std::span<const Rung> rungs, SceneClass scene_class, Simulated what,
                         double accuracy, bool own) {
  const Rung* cheapest = nullptr;
  for (const Rung& rung : rungs) {
    if (rung.scene_class != scene_class || IsOwn(rung.method) != own) continue;
    if (!(ErrorOf(rung, what) <= accuracy)) continue;
    if (cheapest == nullptr || rung.seconds < cheapest->seconds) cheapest = &rung;
  }
  return cheapest;
}

double ProbeMachine(SceneClass scene_class) {
  // the best of the runs that a fifth of a second has room for
  double best_s = HUGE_VAL;
  for (double spent_s = 0; spent_s < kProbeS;) {
    const double run_s = TimeOfRun(scene_class, kProbeTolerance);
    spent_s += run_s;
    best_s = std::min(best_s, run_s);
  }
  // against the same run on the machine of the ladders
  const bool smooth = scene_class == SceneClass::kSmooth;
  const auto rung = std::ranges::find_if(ShippedRungs(), [&](const Rung& r) {
    return r.scene_class == scene_class &&
           (smooth ? r.method == "SmoothMotion" && r.setting == kProbeSetting
                   : r.method == "exact with events");
  });
  HAPTOMETER_CHECK(rung != ShippedRungs().end(), "no rung of {}", NameOf(scene_class));
  return best_s / rung->seconds;
}

std::vector<Rung> RungsHere(const MachineRatios& ratios) {
  std::vector<Rung> rungs = ShippedRungs();
  for (Rung& rung : rungs) rung.seconds *= ratios[static_cast<std::size_t>(rung.scene_class)];
  return rungs;
}

}  // namespace haptometer::tools
