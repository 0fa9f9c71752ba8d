#pragma once

#include <optional>
#include <string>

#include "sim/effective_scene.h"
#include "sim/periodic_motion.h"
#include "sim/scene_run.h"

namespace haptometer::sim {

/// What a scene's motion settles to, played for eight periods of the drive.
struct SteadyRun {
  std::optional<SceneRun> run;  ///< absent: none was found
  /// How it repeats itself; absent where it is the linear steady motion, which nothing limits.
  std::optional<PeriodicMotion> periodic;
  PiecewiseStart start;           ///< at phase 0 of the drive, where there is a run
  double temperature_rise_k = 0;  ///< of the coil there
  std::string tried;              ///< in words, why there is no run
};

/// The linear steady motion where it stays clear of stops and keeps contact, else the periodic
/// motion that the scene settles to from rest (periodic_motion.h), a stable one.
///
/// **Tremor** has no period in common with the drive. In a linear steady motion that nothing limits
/// it is superposed (superposition.h): the run then has RMS and power over a long time, the mover's
/// peak as a sum of amplitudes, and the skin's waveform over eight periods of the drive from t = 0.
/// Else there is no run.
///
/// **Smooth effects**: shooting over SmoothMotion, the coil's temperature among the unknowns, so
/// that its time constant costs nothing; a coil that no heat leaves has no steady motion. First
/// with a hundred times the solver's tolerance, from there with the tolerance itself, which is
/// made smaller as in RunScene; error_estimate is ErrorOf the last two motions.
///
/// The scene must have a linear steady state (SolveSteadyState's error_estimate below 1). Cost: ten
/// microseconds for a linear one, from 100 periods of PiecewiseMotion for another, from 300 of
/// SmoothMotion for a smooth one, some 0.3 s.
[[nodiscard]] SteadyRun PlaySteady(const EffectiveScene& scene);

}  // namespace haptometer::sim
