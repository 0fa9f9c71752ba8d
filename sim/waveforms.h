#pragma once

#include <Eigen/Core>
#include <optional>

#include "sim/effective_scene.h"
#include "sim/piecewise/piecewise_motion.h"
#include "sim/scene/scene.h"

namespace haptometer::sim {

/// Everything that moves and flows in a scene, at equal times: row i at i / rate_hz. (rows) each.
///
/// Positions count from where the bodies rest under weight and preload, towards the skin positive;
/// "skin" is what touches it, the adapter's skin side or the case, also in flight.
struct Waveforms {
  double rate_hz = 0;
  Eigen::VectorXd voltage_v;  ///< of the source, ahead of its resistance
  Eigen::VectorXd current_a;
  Eigen::VectorXd mover_m, mover_m_per_s;
  Eigen::VectorXd case_m, case_m_per_s;
  Eigen::VectorXd skin_m, skin_m_per_s;
  Eigen::VectorXd finger_m;  ///< empty where it rests
  /// What presses on the skin: F0 + Ks (xs - xg) + Bs (vs - vg), F0 the preload with what weight
  /// adds; 0 in flight. Below 0 a skin that cannot break contact pulls.
  Eigen::VectorXd force_n;
  /// Least of that, between rows too; absent unless asked for.
  std::optional<double> force_least_n{};
  Eigen::VectorXd events;                ///< how many since the row before
  std::optional<double> stalled_at_s{};  ///< events without end: the last row is before that

  [[nodiscard]] Eigen::Index rows() const { return voltage_v.size(); }
};

/// What presses contactor and skin together at rest: the stated preload, and the bodies' weight
/// where the scene calls for gravity; 0 where neither is there.
[[nodiscard]] double RestingForceN(const EffectiveScene& scene);

/// Where a motion begins.
struct Beginning {
  PiecewiseStart start;
  double temperature_rise_k = 0;  ///< of a coil that warms
};

/// Where the scene's motion begins: at rest, or in its steady motion. That of a sine which effects
/// change is searched for (steady_run.h); where none is found, and of tones under effects, at rest.
[[nodiscard]] Beginning BeginningOf(const EffectiveScene& scene);

/// Plays the scene from its beginning for `duration_s`, rows 0 to floor(duration_s rate_hz).
///
/// Exact at any rate, under smooth effects to the scene's tolerance as SolverLadder begins with
/// it; an event shows in `events` of the row behind it. duration_s rate_hz at most 1e8. Cost:
/// PiecewiseMotion's without energies, or SmoothMotion's; `with_least_force` 0.1 us more a row.
/// Memory: eleven numbers a row.
[[nodiscard]] Waveforms PlayWaveforms(const EffectiveScene& scene, Beginning beginning,
                                      double duration_s, double rate_hz,
                                      bool with_least_force = false);

}  // namespace haptometer::sim
