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
  /// The linear steady motion; absent where stops or lost contact limit it, smooth effects bend it
  /// or tremor adds to it. Without a duration
  /// `effects` then has the motion that the scene settles to.
  std::optional<sim::SteadyState> steady;
  double skin_rms_relative_uncertainty = 0;  ///< from the actuator's; 0: stated as exact
  std::optional<WindowAnswer> window;        ///< with a duration of at least ten periods
  /// What became of its effects, and the run that they were decided by; absent where the scene
  /// names none.
  std::optional<sim::EffectChoice> effects;
};

/// The motion that a scene without a duration settles to where it is not `steady`; null for others.
[[nodiscard]] const sim::SceneRun* SettledRun(const SceneAnswer& answer);

/// Decides the scene's effects; `where` names it in errors.
/// Errors (Cause::kCannotAnswer): ChooseEffects's; a run too long to play.
[[nodiscard]] Result<sim::EffectChoice> DecideEffects(const sim::Scene& scene,
                                                      const std::string& where);

/// Solves the scene; `where` names it in errors.
/// Errors (Cause::kCannotAnswer): an undamped resonance, where there is no steady state; events
/// without end; a run too long to play; a scene without a duration whose motion settles to nothing
/// that was found.
[[nodiscard]] Result<SceneAnswer> AnswerScene(const sim::Scene& scene, const std::string& where);

}  // namespace haptometer::tools
