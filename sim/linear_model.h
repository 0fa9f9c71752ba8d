#pragma once

#include <Eigen/Core>
#include <optional>

#include "sim/scene.h"

namespace haptometer::sim {

/// The linear model x' = A x + B v, states in SI units (A, m, m/s), v the terminal voltage in V.
///
/// With an adapter (n = 7):     x = [i, xv, vv, xa, va, xs, vs]
/// without an adapter (n = 5):  x = [i, xv, vv, xa, va], and xa is the skin's position too.
/// i: coil current; v, a, s: moving mass, motor case, skin contact; each x its displacement from
/// rest, each v its velocity. Lindsay 2013, equations 2.1-2.4 as in matrix 2.5, that is with the
/// reaction +Km i on the case, which equation 2.3 as printed leaves out (without it the force pair
/// would not balance and energy would not be conserved).
struct LinearModel {
  Eigen::MatrixXd a;  ///< (n, n)
  Eigen::VectorXd b;  ///< (n): [1/L, 0, ...]

  // which state is what
  static constexpr Eigen::Index kCurrent = 0;
  static constexpr Eigen::Index kMover = 1;
  static constexpr Eigen::Index kMoverVelocity = 2;
  static constexpr Eigen::Index kCase = 3;
  static constexpr Eigen::Index kCaseVelocity = 4;
  [[nodiscard]] Eigen::Index states() const { return a.rows(); }
  [[nodiscard]] Eigen::Index skin() const { return states() == 7 ? 5 : kCase; }
  [[nodiscard]] Eigen::Index skin_velocity() const { return skin() + 1; }
};

/// Assembles the states that the bodies need. The actuator must be complete, its masses, resistance
/// and inductance positive; stiffnesses and dampings may be zero (a free case: skin {0, 0}).
[[nodiscard]] LinearModel AssembleModel(const Actuator& actuator,
                                        const std::optional<Adapter>& adapter, const Skin& skin);

/// The same of a scene's bodies.
[[nodiscard]] LinearModel AssembleModel(const Scene& scene);

/// The state that the sensor's target is.
[[nodiscard]] Eigen::Index StateOf(const LinearModel& model, SensorTarget target);

}  // namespace haptometer::sim
