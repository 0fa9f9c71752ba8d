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

std::optional<WindowAnswer> WindowOf(const SceneAnswer& answer) {
  if (!answer.effects) return AnswerWindow(answer.scene);
  const sim::SceneRun& run = answer.effects->run;
  const double length_s = kWindowPeriods / answer.scene.drive.frequency_hz;
  if (!answer.scene.duration_s || run.end_s - run.begin_s < length_s * (1 - 1e-9)) return {};
  return WindowAnswer{.begin_s = run.begin_s, .end_s = run.end_s, .skin_rms_m = run.skin_rms_m};
}

}  // namespace

const sim::SceneRun* SettledRun(const SceneAnswer& answer) {
  const bool settled = !answer.scene.duration_s && answer.effects && !answer.steady;
  return settled ? &answer.effects->run : nullptr;
}

Result<sim::EffectChoice> DecideEffects(const sim::Scene& scene, const std::string& where) {
  const double duration_s = scene.duration_s.value_or(0);
  const double outputs = duration_s * scene.drive.frequency_hz * sim::kOutputsPerPeriod;
  if (outputs > sim::kMostOutputs) {
    return CannotAnswer(where,
                        fmt::format("{:g} s are {:.2g} steps with effects", duration_s, outputs),
                        fmt::format("shorten duration_s to {:.3g} s or less",
                                    duration_s * sim::kMostOutputs / outputs));
  }
  return sim::ChooseEffects(scene, where);
}

Result<SceneAnswer> AnswerScene(const sim::Scene& scene, const std::string& where) {
  SceneAnswer answer;
  answer.scene = scene;
  const sim::SteadyState linear = sim::SolveSteadyState(scene);
  if (!(linear.error_estimate < 1)) {
    return CannotAnswer(where, "has no steady state: the drive meets an undamped resonance",
                        "add damping or change frequency_hz");
  }
  answer.steady = linear;
  if (scene.effects.Asked()) {
    auto choice = DecideEffects(scene, where);
    if (!choice) return std::unexpected(choice.error());
    const sim::EffectiveScene effective = sim::WithEffects(scene, choice->on);
    answer.steady = sim::SolveSteadyState(effective.scene);
    if (!sim::SteadyMotionIsFree(effective, *answer.steady)) answer.steady.reset();
    answer.effects = std::move(*choice);
  }
  if (answer.steady) answer.skin_rms_relative_uncertainty = sim::SkinRmsUncertainty(scene);
  answer.window = WindowOf(answer);
  return answer;
}

}  // namespace haptometer::tools
