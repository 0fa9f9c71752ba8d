#pragma once

#include <Eigen/Core>

#include "sim/scene.h"

namespace haptometer::sim {

/// The steady motion of a linear scene under its sine and its finger's tones together, long after
/// every transient.
///
/// Each frequency has its own phasors; tones of the very same frequency add before they are
/// squared. Over a long time the powers of different frequencies add, and so their squares do:
///
///   rms^2 = mean^2 + sum over frequencies of |X|^2 / 2
///
/// Amplitudes add: sums that are reached, as nearly as one likes, where frequencies have no common
/// period, and are bounds where they have one.
struct Superposition {
  double skin_rms_m = 0;
  double case_rms_m = 0;
  double current_rms_a = 0;
  double power_w = 0;            ///< mean of v i, and of what the finger puts in
  double mover_peak_m = 0;       ///< sum of the amplitudes of xv - xa
  double skin_force_peak_n = 0;  ///< sum of those of Ks (xs - xg) + Bs (vs - vg)
  double mean_travel_m = 0;      ///< of mover_peak_m what an offset holds, with its sign
  double mean_skin_force_n = 0;  ///< the same of the force
  Eigen::VectorXd state;         ///< (n) at t = 0: what begins the steady motion
  /// The largest of SteadyState's over the frequencies; 1 or more: there is no steady motion.
  double error_estimate = 0;
};

/// Cost: three factorisations for each of the finger's tones, and the drive's.
[[nodiscard]] Superposition Superpose(const Scene& scene);

}  // namespace haptometer::sim
