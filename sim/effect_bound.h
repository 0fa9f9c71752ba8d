#pragma once

#include <array>

#include "sim/scene/effects.h"
#include "sim/scene/scene.h"
#include "sim/scene_run.h"

namespace haptometer::sim {

/// By Effect, the largest relative change of any number of a run, and of its waveform over its
/// peak, that leaving this effect out of a scene makes; infinite where none is known.
using EffectBounds = std::array<double, kEffectNames.size()>;

/// What disturbs a linear motion: stiffening, coil heating, tremor.
inline constexpr std::array kDisturbances{Effect::kStiffening, Effect::kCoilHeating,
                                          Effect::kTremor};

/// `on` without kDisturbances: the base of the bounds.
[[nodiscard]] EffectSet WithoutDisturbances(EffectSet on);

/// Bounds of what each of kDisturbances in `on` changes, from a motion without them and without a
/// step of the solver.
///
/// Each disturbs the linear scene by a force F between mover and case, by a voltage E in the coil,
/// or by the tremor's own steady motion and its transient:
///
///   F = K3 d (d^2 + 3 s d + 3 s^2)       E = R0 alpha theta i       C theta' = R i^2 - theta / Rth
///
/// A disturbance of at most F moves an output by at most F times the integral of its impulse
/// response's magnitude, which its modes bound: sum of |c v_k| |w_k b| / |Re p_k|, 2 / pi of that
/// of a mode that rings. So travel D and current I of the disturbed motion satisfy D <= D0 + g_dF
/// F(D) + g_dE E(I), and I the like; from a solution in which the disturbance contracts, the motion
/// exists, is that which the start leads to, and all numbers follow (M. Vidyasagar, Nonlinear
/// Systems Analysis, 2nd ed., 6.6, small gain). Leaving one effect out where the others stay is
/// amplified by (1 - gain)^-1.
///
/// `base` is the run of WithoutDisturbances(on), a linear one: nothing was reached in it. Infinite
/// throughout where the disturbed motion may reach a stop or leave the skin, where two modes are
/// nearly one (condition above 1e10), and where a coil heats by more than a fifth of its
/// resistance.
///
/// Some hundred times the change at a resonance, away from it Q times that. Cost: some 0.1 ms.
[[nodiscard]] EffectBounds BoundEffects(const Scene& scene, EffectSet on, const SceneRun& base);

}  // namespace haptometer::sim
