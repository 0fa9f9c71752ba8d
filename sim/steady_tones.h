#pragma once

#include <Eigen/Core>

#include "sim/linear_model.h"
#include "sim/scene.h"

namespace haptometer::sim {

/// The motion under several tones, long after every transient: the steady motions of each,
/// superposed. RMS values and power are those over all time.
struct SteadyTones {
  Eigen::VectorXd start;  ///< (n): the states at t = 0
  double skin_rms_m = 0;  ///< sqrt(mean^2 + sum |Xs_k|^2 / 2) over the frequencies k; so are these:
  double case_rms_m = 0;
  double current_rms_a = 0;
  double power_w = 0;            ///< mean electrical power taken from the source: sum of the tones'
  double skin_power_w = 0;       ///< of it what the skin's damper takes
  double mover_peak_m = 0;       ///< largest |xv - xa|
  double skin_force_peak_n = 0;  ///< largest |Ks xs + Bs vs|
  double mean_skin_force_n = 0;  ///< what an offset holds of it
  /// After how long all repeats itself; 0: after more than 2^20 outputs, 64 in the shortest period,
  /// or never. The two peaks are then the sums of the tones' amplitudes: never more than that, and
  /// nearly that now and then where the frequencies have nothing in common.
  double period_s = 0;
  /// Of skin_rms_m, the largest of the tones' (steady_state.h). 1 or more: a tone meets an undamped
  /// resonance, and the other fields hold nothing.
  double error_estimate = 0;
};

/// Solves for a scene whose drive are tones.
///
/// Tones of equal frequency are added up first. The common period is that of the frequencies as
/// decimals of a microhertz; over it the peaks are those of the quintics through 64 outputs in the
/// shortest period (hermite.h), 2e-11 of the sum of amplitudes. Cost: a SolveSteadyState a tone,
/// and 0.1 us a tone for each output.
[[nodiscard]] SteadyTones SolveSteadyTones(const Scene& scene);

}  // namespace haptometer::sim
