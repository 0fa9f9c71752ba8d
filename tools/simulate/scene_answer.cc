#include "tools/simulate/scene_answer.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "sim/effective_scene.h"
#include "sim/linear_model.h"
#include "sim/time_response.h"

namespace haptometer::tools {
namespace {

constexpr double kWindowPeriods = 10;

// The last ten periods of the run, where it has as many.
std::optional<WindowAnswer> AnswerWindow(const sim::Scene& scene) {
  if (!scene.duration_s) return std::nullopt;
  const double length_s = kWindowPeriods / scene.drive.frequency_hz;
  // a run of exactly ten periods may miss them by a rounding
  const double begin_s = *scene.duration_s - length_s;
  if (begin_s < -1e-12 * length_s) return std::nullopt;
  const sim::LinearModel model = sim::AssembleModel(scene);
  const sim::TimeResponse response(model, scene.drive, sim::StartOf(scene));
  WindowAnswer window{.begin_s = std::max(0.0, begin_s), .end_s = *scene.duration_s};
  window.skin_rms_m = response.WindowRms(model.skin(), window.begin_s, window.end_s);
  return window;
}

Result<sim::EffectChoice> DecideEffects(const sim::Scene& scene, const std::string& where) {
  const double duration_s = DecidingDuration(scene);
  const double outputs = duration_s * scene.drive.frequency_hz * sim::kOutputsPerPeriod;
  if (outputs > sim::kMostOutputs) {
    return CannotAnswer(where,
                        fmt::format("{:g} s are {:.2g} steps with effects", duration_s, outputs),
                        fmt::format("shorten duration_s to {:.3g} s or less",
                                    duration_s * sim::kMostOutputs / outputs));
  }
  sim::EffectChoice choice = sim::ChooseEffects(scene, duration_s);
  if (choice.run.stalled_at_s) {
    return CannotAnswer(where,
                        fmt::format("has events without end at {:.9g} s", *choice.run.stalled_at_s),
                        "give the stops less stiffness or a restitution below 1");
  }
  return choice;
}

// the linear steady motion where nothing limits it
Result<void> AnswerSteady(const sim::EffectiveScene& effective, const std::string& where,
                          SceneAnswer& answer) {
  const sim::SteadyState steady = sim::SolveSteadyState(effective.scene);
  if (!(steady.error_estimate < 1)) {
    return CannotAnswer(where, "has no steady state: the drive meets an undamped resonance",
                        "add damping or change frequency_hz");
  }
  if (!sim::SteadyMotionIsFree(effective, steady)) {
    answer.no_steady_because =
        "stops or lost contact limit the steady motion, which is not searched for yet";
    if (answer.scene.duration_s) return {};
    return CannotAnswer(where, answer.no_steady_because, "give a duration");
  }
  answer.steady = steady;
  answer.skin_rms_relative_uncertainty = sim::SkinRmsUncertainty(effective.scene);
  return {};
}

std::optional<WindowAnswer> WindowOf(const SceneAnswer& answer) {
  if (!answer.effects) return AnswerWindow(answer.scene);
  const sim::SceneRun& run = answer.effects->run;
  const double length_s = kWindowPeriods / answer.scene.drive.frequency_hz;
  if (!answer.scene.duration_s || run.end_s - run.begin_s < length_s * (1 - 1e-9)) return {};
  return WindowAnswer{.begin_s = run.begin_s, .end_s = run.end_s, .skin_rms_m = run.skin_rms_m};
}

}  // namespace

double DecidingDuration(const sim::Scene& scene) {
  return scene.duration_s.value_or(kWindowPeriods / scene.drive.frequency_hz);
}

Result<SceneAnswer> AnswerScene(const sim::Scene& scene, const std::string& where) {
  SceneAnswer answer;
  answer.scene = scene;
  sim::EffectiveScene effective{.scene = scene, .piecewise = {}};
  if (scene.effects.Asked()) {
    auto choice = DecideEffects(scene, where);
    if (!choice) return std::unexpected(choice.error());
    effective = sim::WithEffects(scene, choice->on);
    answer.effects = std::move(*choice);
  }
  if (auto solved = AnswerSteady(effective, where, answer); !solved) {
    return std::unexpected(solved.error());
  }
  answer.window = WindowOf(answer);
  return answer;
}

}  // namespace haptometer::tools
