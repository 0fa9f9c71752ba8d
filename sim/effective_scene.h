#pragma once

#include "sim/effects.h"
#include "sim/output_rate.h"
#include "sim/piecewise_scene.h"
#include "sim/scene.h"
#include "sim/smooth_scene.h"
#include "sim/steady_state.h"
#include "sim/superposition.h"

namespace haptometer::sim {

/// A scene with a choice of effects folded into its numbers: what is solved.
struct EffectiveScene {
  /// Inductance 0 where the choice leaves it out, a finger that rests without tremor.
  Scene scene;
  PiecewiseEffects piecewise;  ///< gaps and preload as they are where gravity has moved the bodies
  SmoothEffects smooth{};      ///< the spring stretched by its sag
  /// How often its motion is looked at: as the stated scene's, so that the runs of all choices have
  /// the same outputs; 0: OutputRateHz(scene).
  double outputs_rate_hz = 0;

  /// Of a sine at the end of a run: what its numbers are of.
  int window_periods = 10;

  [[nodiscard]] double RateHz() const {
    return outputs_rate_hz > 0 ? outputs_rate_hz : OutputRateHz(scene);
  }

  /// Superposition holds as long as nothing in `piecewise` is reached.
  [[nodiscard]] bool IsLinear() const { return !smooth.Any(); }
};

/// How far the mover's preload F, and with gravity its weight, move it in its case, towards the
/// skin positive: s = (F + Mv g) / Kv, or of the stiffening spring Kv s + K3 s^3 = F + Mv g.
[[nodiscard]] double MoverSag(const Scene& scene, bool gravity, bool stiffening = false);

/// The weight of all bodies, which adds to the preload: g (Mv + Mc + Ma1 + Ma2); 0 where the case
/// is held, which carries it.
[[nodiscard]] double Weight(const Scene& scene);

/// What presses on the skin at rest besides its own preload: the mover's preload, with gravity the
/// weight; 0 where the case is held.
[[nodiscard]] double PressOnSkin(const Scene& scene, bool gravity);

/// The scene under a choice. Positions count from static equilibrium, so gravity leaves the motion
/// as it is and moves what limits it: gap_up - s, gap_down + s, preload + weight. The constants of
/// every chosen effect must be there, gaps and preload positive with gravity in them.
[[nodiscard]] EffectiveScene WithEffects(const Scene& scene, EffectSet on);

/// Where a motion from t = 0 begins, with the effects that limit it: as PiecewiseStartOf, and where
/// weight or the mover's preload hold it at a stop, resting there: against a rigid stop in contact,
/// in a compliant one as deep as carries the force.
[[nodiscard]] PiecewiseStart StartIn(const EffectiveScene& scene);

/// Whether weight or a preload hold the mover at one of its stops.
[[nodiscard]] bool RestsOnStop(const EffectiveScene& scene);

/// Whether the scene can rest before anything moves: a preload that presses, a skin that carries
/// it.
[[nodiscard]] bool CanRest(const EffectiveScene& scene);

/// Whether the steady motion of the linear scene under drive and tremor is one of the scene:
/// nothing smooth bends it, it stays clear of stops and keeps contact. By the amplitudes of travel
/// and skin force: exact under one tone, on the safe side under several.
[[nodiscard]] bool SteadyMotionIsFree(const EffectiveScene& scene, const SteadyState& steady);
[[nodiscard]] bool SteadyMotionIsFree(const EffectiveScene& scene, const Superposition& steady);

}  // namespace haptometer::sim
