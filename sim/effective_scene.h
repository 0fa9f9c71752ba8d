#pragma once

#include "sim/effects.h"
#include "sim/piecewise_scene.h"
#include "sim/scene.h"
#include "sim/steady_state.h"

namespace haptometer::sim {

/// A scene with a choice of effects folded into its numbers: what is solved.
struct EffectiveScene {
  Scene scene;                 ///< inductance 0 where the choice leaves it out
  PiecewiseEffects piecewise;  ///< gaps and preload as they are where gravity has moved the bodies
};

/// How far gravity moves the mover in its case: s = Mv g / Kv, towards the skin positive.
[[nodiscard]] double MoverSag(const Scene& scene);

/// The weight of all bodies, which adds to the preload: g (Mv + Mc + Ma1 + Ma2).
[[nodiscard]] double Weight(const Scene& scene);

/// The scene under a choice. Positions count from static equilibrium, so gravity leaves the motion
/// as it is and moves what limits it: gap_up - s, gap_down + s, preload + weight. The constants of
/// every chosen effect must be there, gaps and preload positive with gravity in them.
[[nodiscard]] EffectiveScene WithEffects(const Scene& scene, EffectSet on);

/// Whether the scene can rest before anything moves: room to every stop, a preload that presses, a
/// skin that carries it.
[[nodiscard]] bool CanRest(const EffectiveScene& scene);

/// Whether the linear steady motion stays clear of stops and keeps contact: then it is a motion of
/// the scene with them, too. By the amplitudes of travel and skin force, exact under a sine.
[[nodiscard]] bool SteadyMotionIsFree(const EffectiveScene& scene, const SteadyState& steady);

}  // namespace haptometer::sim
