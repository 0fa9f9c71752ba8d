#pragma once

#include <optional>

#include "sim/effective_scene.h"
#include "sim/findings.h"
#include "sim/periodic_motion.h"
#include "sim/scene_run.h"

namespace haptometer::sim {

/// What a scene's motion settles to, played for as many whole periods of its own as eight of the
/// drive need.
struct SteadyRun {
  std::optional<SceneRun> run;  ///< absent: none was found
  /// How it repeats itself; absent where it is the linear steady motion, which nothing limits.
  std::optional<PeriodicMotion> periodic;
  /// Present where the motion is chaotic: `run` is then over ChaoticMotion::periods, its numbers
  /// are averages over all of them, and its error_estimate is the largest of their relative
  /// standard uncertainties.
  std::optional<ChaoticMotion> chaotic{};
  PiecewiseStart start;            ///< at phase 0 of the drive, where there is a run
  double temperature_rise_k = 0;   ///< of the coil there
  std::optional<Finding> refusal;  ///< why there is no run
};

/// The motion that the transient from rest, or from the stated initial state, leads to: the linear
/// steady motion where that transient and the motion itself stay clear of stops and keep contact,
/// else what periodic_motion.h finds: a motion that repeats itself every 1 to 32 periods of the
/// drive, or a chaotic one's averages.
///
/// **Tremor** has no period in common with the drive. In a linear steady motion that nothing limits
/// it is superposed (sim/linear/steady_state.h): the run then has RMS and power over a long time,
/// the mover's peak as a sum of amplitudes, and the skin's waveform over eight periods of the drive
/// from t = 0. Else there is no run.
///
/// **Smooth effects**: shooting over SmoothMotion, the coil's temperature among the unknowns, so
/// that its time constant costs nothing; a coil that no heat leaves has no steady motion. First
/// with the looser settings of SolverLadder, from there with the tolerance itself, which is
/// made smaller as in RunScene; error_estimate is ErrorOf the last two motions.
///
/// The scene must have a linear steady state (SolveSteadyState's error_estimate below 1). Cost: ten
/// microseconds for a linear one without limits, a millisecond with them, from 100 periods of
/// PiecewiseMotion for another, from 300 of SmoothMotion for a smooth one, some 0.3 s.
[[nodiscard]] SteadyRun PlaySteady(const EffectiveScene& scene);

/// After how many periods of the drive, 1 to 32, the end of a run repeats itself: the smallest k
/// for which each of its last k periods ends within 1e-4 of where the one k before ended; absent:
/// none, the run is too short (2 k periods) or its transient goes on.
[[nodiscard]] std::optional<int> PeriodAtEnd(const SceneRun& run);

/// Relative standard deviation of the skin's RMS over windows of so many periods, over those that
/// are marked: what a window of that length is uncertain by in a motion that does not repeat
/// itself. Absent where there are not two of them.
[[nodiscard]] std::optional<double> WindowUncertainty(const SceneRun& run, int window_periods);

}  // namespace haptometer::sim
