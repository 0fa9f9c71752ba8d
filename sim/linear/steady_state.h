#pragma once

#include <Eigen/Core>
#include <complex>

#include "sim/linear/linear_model.h"
#include "sim/scene/scene.h"

namespace haptometer::sim {

/// The periodic motion under a sine drive, long after every transient.
struct SteadyState {
  /// (n) peak phasors X: with v(t) = V0 + V sin(w t), state k is mean[k] + Im(X[k] exp(j w t)).
  Eigen::VectorXcd phasors;
  Eigen::VectorXd mean;            ///< (n): the constant part, of the drive's offset; 0 without one
  std::complex<double> current_a;  ///< peak phasor of the coil's current

  double skin_rms_m = 0;    ///< of all of xs, the constant part included; so are the others
  double mover_peak_m = 0;  ///< largest travel of the moving mass in the case, either way
  double case_rms_m = 0;
  double current_rms_a = 0;
  /// Mean electrical power taken from the source: what is dissipated, which loses no digits where
  /// the current is all but a quarter of a period from the voltage.
  double power_w = 0;
  double phase_rad = 0;          ///< of the current relative to the voltage; negative: it lags
  double skin_force_peak_n = 0;  ///< largest Ks xs + Bs vs either way
  /// Its least value, with its sign: a preload below its negative lifts off.
  double skin_force_least_n = 0;
  double mean_current_a = 0;
  double mean_travel_m = 0;      ///< of mover_peak_m, with its sign
  double mean_skin_force_n = 0;  ///< of skin_force_peak_n, with its sign
  /// Bound of the relative error of all numbers above: residual and rounding of the matrix, both
  /// carried through |M^-1|, M = j w I - A, and what rounding adds to the numbers themselves. Of a
  /// stiff mover (LinearModel::a_rest) w and the matrix count with their 64 bits. 1 or more
  /// (also infinite): the drive excites an undamped resonance or the inertia of floating bodies is
  /// lost beside their springs, and there is no steady state that doubles can tell;
  /// the other fields then hold nothing.
  double error_estimate = 0;
};

/// Solves (j w I - A) X = B V with row and column scaling by powers of two and one refinement.
///
/// `skin` is needed for the skin's force only. Cost: two factorisations of a complex (7, 7) matrix,
/// microseconds; allocates; threads may share nothing or everything.
[[nodiscard]] SteadyState SolveSteadyState(const LinearModel& model, const SineDrive& drive,
                                           const Skin& skin);

/// The same of a scene; no steady state (error_estimate infinite) where an offset moves bodies
/// that no spring holds in their place.
[[nodiscard]] SteadyState SolveSteadyState(const Scene& scene);

/// Whether a spring, or a case that is held, brings every body back to where it was.
[[nodiscard]] bool IsHeldInPlace(const Scene& scene);

/// (n): where a constant voltage holds the states in the end, -A^-1 B V. A must be regular
/// (IsHeldInPlace). Zeros of 0 V.
[[nodiscard]] Eigen::VectorXd StaticState(const LinearModel& model, double voltage_v);

/// Relative standard uncertainty of skin_rms_m from how well the scene's actuator is known.
///
///   u^2 = g' C g,  g the derivatives of ln RMS by the logarithms of the seven numbers
///
/// First order (JCGM 100:2008, 5.2.2), g by central differences of 1e-4: good to 1e-6 of itself
/// where the uncertainties are small against the resonance's width. Cost: 14 steady states.
[[nodiscard]] double SkinRmsUncertainty(const Scene& scene);

/// The motion of a linear scene under several tones, long after every transient: the steady motions
/// of each, superposed. RMS values and power are those over all time.
///
/// Each frequency has its own phasors; tones of the very same frequency add before they are
/// squared. Over a long time the powers of different frequencies add, and so their squares do:
///
///   rms^2 = mean^2 + sum over frequencies of |X|^2 / 2
struct SteadyTones {
  Eigen::VectorXd start;  ///< (n): the states at t = 0, which begin the steady motion
  double skin_rms_m = 0;
  double case_rms_m = 0;
  double current_rms_a = 0;
  double power_w = 0;             ///< mean of v i, and of what the finger puts in
  double skin_power_w = 0;        ///< of it what the skin's damper takes
  double mover_peak_m = 0;        ///< largest |xv - xa|
  double skin_force_peak_n = 0;   ///< largest |Ks (xs - xg) + Bs (vs - vg)|
  double skin_force_least_n = 0;  ///< its least value, with its sign
  double mean_travel_m = 0;       ///< of mover_peak_m what an offset holds, with its sign
  double mean_skin_force_n = 0;   ///< the same of the force
  /// After how long all repeats itself; 0: after more than 2^20 outputs, 64 in the shortest period,
  /// or never, or not looked for. The two peaks are then the sums of the tones' amplitudes: never
  /// more than that, and nearly that now and then where the frequencies have nothing in common.
  double period_s = 0;
  /// The largest of SteadyState's over the frequencies. 1 or more: a tone meets an undamped
  /// resonance, there is no steady motion, and the other fields hold nothing.
  double error_estimate = 0;
};

/// Under the scene's sine and its finger's tones together, whose common period is not looked for.
/// Cost: three factorisations for each of the finger's frequencies, and the drive's.
[[nodiscard]] SteadyTones Superpose(const Scene& scene);

/// Under a drive that is tones, the finger at rest.
///
/// The common period is that of the frequencies as decimals of a microhertz; over it the peaks are
/// those of the quintics through 64 outputs in the shortest period (sim/linear/time_response.h),
/// 2e-11 of the sum of amplitudes. Cost: a SolveSteadyState a tone, and 0.1 us a tone for each
/// output.
[[nodiscard]] SteadyTones SolveSteadyTones(const Scene& scene);

}  // namespace haptometer::sim
