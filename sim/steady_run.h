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
  PiecewiseStart start;  ///< at phase 0 of the drive, where there is a run
  std::string tried;     ///< in words, where a periodic motion was searched for
};

/// The linear steady motion where it stays clear of stops and keeps contact, else the periodic
/// motion that the scene settles to from rest (periodic_motion.h), a stable one.
///
/// The scene must have a linear steady state (SolveSteadyState's error_estimate below 1). Cost: ten
/// microseconds for a linear one, from 100 periods of PiecewiseMotion for another.
[[nodiscard]] SteadyRun PlaySteady(const EffectiveScene& scene);

}  // namespace haptometer::sim
