#pragma once

#include <Eigen/Core>
#include <complex>
#include <optional>
#include <vector>

#include "sim/linear/driven_step.h"
#include "sim/scene/scene.h"

namespace haptometer::sim {

/// The linear model x' = A x + B v, states in SI units (m, m/s, A), v the terminal voltage in V.
///
/// With an adapter (n = 7):     x = [xv, vv, xa, va, xs, vs, i]
/// without an adapter (n = 5):  x = [xv, vv, xa, va, i], and xa is the skin's position too.
/// v, a, s: moving mass, motor case, skin contact; each x its displacement from rest, each v its
/// velocity; i: coil current. Lindsay 2013, equations 2.1-2.4 as in matrix 2.5 (there the current
/// is the first state), that is with the reaction +Km i on the case, which equation 2.3 as printed
/// leaves out (without it the force pair would not balance and energy would not be conserved).
///
/// A coil without inductance has no state: n = 6 and 4. Its current follows from the others,
///
///   i = (v + Km (vv - va)) / R,
///
/// which is a damper Km^2/R between mover and case and a force Km v / R on the case.
struct LinearModel {
  Eigen::MatrixXd a;               ///< (n, n)
  Eigen::VectorXd b;               ///< (n): 1/L in the current's row, or what Km v / R does
  Eigen::RowVectorXd current_row;  ///< (n): i = current_row x + current_per_volt v
  double current_per_volt = 0;     ///< 1/R without inductance, else 0
  /// (n, n) and (n): what rounding left out of a and b, so that a + a_rest has the 64 bits of long
  /// double. Empty, and of no consequence, unless mover and case are all but one body: the coil's
  /// force and the spring's are equal and opposite, and beyond kStiffMoverRadPerS their rounding by
  /// eps moves the rest of the scene as visibly as what they truly leave over.
  Eigen::MatrixXd a_rest{};
  Eigen::VectorXd b_rest{};
  /// (k, n + 1) of [x, v]: what is dissipated is the sum of these rows' squares in W: the coil with
  /// its source, the dampers of mover, grip, adapter and skin.
  Eigen::MatrixXd power_rows{};

  /// sqrt(Kv (1/Mv + 1/Mc1)) above which there is a rest: 3 kHz, where rounding costs 1e-14 of a
  /// state's peak in 0.1 s (5e-13 at 20 kHz, 8e-9 at 1e11 N/m).
  static constexpr double kStiffMoverRadPerS = 2e4;

  // which state is what
  static constexpr Eigen::Index kMover = 0;
  static constexpr Eigen::Index kMoverVelocity = 1;
  static constexpr Eigen::Index kCase = 2;
  static constexpr Eigen::Index kCaseVelocity = 3;
  static constexpr Eigen::Index kMostStates = 7;
  [[nodiscard]] Eigen::Index states() const { return a.rows(); }
  [[nodiscard]] Eigen::Index skin() const { return states() >= 6 ? 4 : kCase; }
  [[nodiscard]] Eigen::Index skin_velocity() const { return skin() + 1; }
};

/// Assembles the states that the bodies need. The actuator must be complete, its masses and
/// resistance positive; inductance, stiffnesses and dampings may be zero (a free case: skin {0,
/// 0}).
[[nodiscard]] LinearModel AssembleModel(const Actuator& actuator,
                                        const std::optional<Adapter>& adapter, const Skin& skin);

/// The same with the case held by a grip. Where it holds rigidly, without an adapter, the case
/// weighs infinitely much: its states are 0 and stay there.
[[nodiscard]] LinearModel AssembleModel(const Actuator& actuator,
                                        const std::optional<Adapter>& adapter, const Skin& skin,
                                        const Grip& grip);

/// The same of a scene's bodies, the source's resistance added to the coil's.
[[nodiscard]] LinearModel AssembleModel(const Scene& scene);

/// a and b of LinearModel with the 64 bits of long double.
struct LongModel {
  LongMatrix a;
  LongVector b;
};

[[nodiscard]] LongModel AssembleLongModel(const Scene& scene);

/// (n): the states of a stated start.
[[nodiscard]] Eigen::VectorXd StatedStart(const InitialState& stated, const LinearModel& model);

/// The state that the sensor's target is.
[[nodiscard]] Eigen::Index StateOf(const LinearModel& model, SensorTarget target);

/// The natural motions exp(p t) of the undriven model: eigenvalues of A in rad/s, by rising |p|. A
/// pair p, p* rings at |p| / 2 pi Hz (undamped) and decays as exp(Re p t).
///
/// Balanced first (sim/linear/driven_step.h): good to about 1e-13 of |p| for the thesis's scenes.
/// Cost: some 20 us; allocates.
[[nodiscard]] std::vector<std::complex<double>> Poles(const LinearModel& model);

}  // namespace haptometer::sim
