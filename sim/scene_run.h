#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "sim/effective_scene.h"
#include "sim/energy_ledger.h"
#include "sim/piecewise_motion.h"

namespace haptometer::sim {

/// How often something happened during a run: "impact up", 12.
struct EventCount {
  std::string_view name;
  std::size_t count = 0;
  double first_s = 0;
};

/// What the motion of a run comes to over its window: the last ten periods of a sine, or all of it
/// where it is shorter or its drive is no sine.
struct SceneRun {
  double begin_s = 0;  ///< of the window
  double end_s = 0;
  double skin_rms_m = 0;     ///< sqrt(1/(end - begin) integral xs^2 dt), an integral, not sampled
  double case_rms_m = 0;     ///< the same of xa
  double current_rms_a = 0;  ///< the same of i
  double power_w = 0;        ///< mean of v i
  double mover_peak_m = 0;   ///< largest abs(xv - xa) in the window
  double mover_peak_of_run_m = 0;  ///< in the whole run, transients included
  double outputs_rate_hz = 0;
  Eigen::VectorXd skin_m;            ///< xs at the window's outputs, begin_s + i / outputs_rate_hz
  EnergyLedger ledger;               ///< of the whole run
  std::vector<EventCount> events{};  ///< of the whole run, in the order in which they first came
  std::optional<double> stalled_at_s{};  ///< events without end: nothing behind it is known
};

/// Outputs within a period of the drive: a peak between two of them is interpolated to 1e-10.
inline constexpr int kOutputsPerPeriod = 64;
/// The longest run in outputs: a minute of work or so.
inline constexpr double kMostOutputs = 1e8;

/// Plays the scene from t = 0 to `duration_s` with its stops and contact (piecewise_motion.h).
///
/// Outputs come as output_rate.h says. Exact but for the peaks: between outputs they follow the
/// quintic through position, velocity and acceleration at both (6th order); where an event lies
/// between, the outputs and a rigid stop's gap alone. duration_s > 0, StepsOfRun at most MostSteps.
/// Cost: PiecewiseMotion's with energies, 64 outputs a period.
[[nodiscard]] SceneRun RunScene(const EffectiveScene& scene, double duration_s);

/// The same from any state at t = 0.
[[nodiscard]] SceneRun RunScene(const EffectiveScene& scene, double duration_s,
                                PiecewiseStart start);

}  // namespace haptometer::sim
