#pragma once

#include <optional>
#include <string>

#include "base/result.h"
#include "sim/effect_choice.h"
#include "sim/scene.h"
#include "sim/steady_state.h"

namespace haptometer::tools {

/// RMS of the skin over the last ten periods of a run.
struct WindowAnswer {
  double begin_s = 0;
  double end_s = 0;
  double skin_rms_m = 0;
};

/// What a scene comes to.
struct SceneAnswer {
  sim::Scene scene;
  std::optional<sim::SteadyState> steady;  ///< absent: not known, as `no_steady_because` says
  std::string no_steady_because;
  double skin_rms_relative_uncertainty = 0;  ///< from the actuator's; 0: stated as exact
  std::optional<WindowAnswer> window;        ///< with a duration of at least ten periods
  /// What became of its effects, and the run that they were decided by; absent where the scene
  /// names none.
  std::optional<sim::EffectChoice> effects;
};

/// The time over which a scene's effects are decided: the run, or ten periods of the drive.
[[nodiscard]] double DecidingDuration(const sim::Scene& scene);

/// Solves the scene; `where` names it in errors.
/// Errors (Cause::kCannotAnswer): an undamped resonance, where there is no steady state; events
/// without end; a run too long to play; a scene without a duration whose steady motion is limited
/// by stops or lost contact.
[[nodiscard]] Result<SceneAnswer> AnswerScene(const sim::Scene& scene, const std::string& where);

}  // namespace haptometer::tools
