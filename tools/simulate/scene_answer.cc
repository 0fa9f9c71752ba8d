#include "tools/simulate/scene_answer.h"

#include <algorithm>

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

}  // namespace

Result<SceneAnswer> AnswerScene(const sim::Scene& scene, const std::string& where) {
  SceneAnswer answer;
  answer.scene = scene;
  answer.steady = sim::SolveSteadyState(scene);
  if (!(answer.steady.error_estimate < 1)) {
    return CannotAnswer(where, "has no steady state: the drive meets an undamped resonance",
                        "add damping or change frequency_hz");
  }
  answer.skin_rms_relative_uncertainty = sim::SkinRmsUncertainty(scene);
  answer.window = AnswerWindow(scene);
  return answer;
}

}  // namespace haptometer::tools
