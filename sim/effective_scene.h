#pragma once

#include <optional>

#include "sim/linear/steady_state.h"
#include "sim/piecewise/piecewise_scene.h"
#include "sim/scene/effects.h"
#include "sim/scene/scene.h"
#include "sim/smooth/smooth_system.h"

namespace haptometer::sim {

/// How often a second a scene's motion is looked at, so that peaks between two looks can be told
/// (sim/linear/time_response.h: to 1e-10 where nothing happens between them).
///
///   sine                 64 f; with a duration whole multiples of that, at least 16 times the
///                        scene's highest own frequency, which may ring (to 1e-7)
///   tones, burst         64 times the highest of the drive's, the finger's and the scene's own
///                        frequencies
///   pulse                64 times the highest of the scene's and the finger's
///   chirp, samples       the same, rounded up to whole multiples of their cubics' or lines' rate:
///                        pieces that end between outputs cost some ten times as much
///
/// The scene's own: Im p / 2 pi of the poles that ring, up to 1e5 Hz. At least 1000 Hz where
/// nothing has a frequency. Cost: Poles().
[[nodiscard]] double OutputRateHz(const Scene& scene);

/// Steps that a run of `duration_s` > 0 takes: its outputs.
[[nodiscard]] double StepsOfRun(const Scene& scene, double duration_s);

/// The most of them: 1e8 of a sine, some half a minute; 1e7 of another drive, all of whose outputs
/// are kept.
[[nodiscard]] double MostSteps(const Scene& scene);

/// How long the undriven linear scene needs until its slowest motion has fallen to a thousandth:
/// ln 1000 / min |Re p|. Nothing where a motion never dies away.
[[nodiscard]] std::optional<double> RingDownS(const Scene& scene);

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
[[nodiscard]] bool SteadyMotionIsFree(const EffectiveScene& scene, const SteadyTones& steady);

}  // namespace haptometer::sim
