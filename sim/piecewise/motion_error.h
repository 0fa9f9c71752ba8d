#pragma once

#include <Eigen/Core>

namespace haptometer::sim {

/// What happens to a small deviation at an event: the state jumps by a map, its rate from one
/// mode's to the other's, and a deviation moves the event's time.
struct EventJump {
  const Eigen::MatrixXd& map;       ///< (n after, n before)
  const Eigen::RowVectorXd& guard;  ///< (n before): g' = dg/dx
  double guard_rate = 0;            ///< g' by time, before
  double guard_curvature = 0;       ///< g'' by time, before
  double guard_rounding = 0;        ///< what rounding makes of g
  Eigen::VectorXd rate_before;      ///< f- (n before)
  Eigen::VectorXd rate_after;       ///< f+ (n after)
  Eigen::VectorXd step_of_state;    ///< x+ - x- where both have the same coordinates, else empty
};

/// The error that a motion of piecewise-linear modes carries: that of every step and every event,
/// propagated to now as independent deviations,
///
///   P(t) = sum over k of Phi(t, t_k) delta_k delta_k' Phi(t, t_k)'
///
/// A step by x+ = Phi x + ... turns it to Phi P Phi' and adds what rounding does, 2^-53 of the
/// terms of each sum. An event turns it to S P S' with the saltation matrix
///
///   S = R + (f+ - R f-) (dg/dx) / (g' by time)
///
/// (M. di Bernardo et al., "Piecewise-smooth Dynamical Systems", 2008, 2.5), and adds the rounding
/// of the event's time. Near a graze that holds only where the guard's error is far below
/// g'^2/(2|g''|): beyond, the event's time is unknown by sqrt(2 error/|g''|), the event itself may
/// come or not, and both jumps enter as errors of their own.
///
/// Bound() takes kSafety standard deviations: the rounding of a step's matrix is the same in every
/// step, so over a resonance's memory of N steps errors add up as N, not as the root of N (with 16
/// one scene of tests/sim/reference/scene_references.json was off by 1.9 times its estimate).
/// Cost: two products of (n, n) matrices a step, 0.5 us.
class MotionError {
 public:
  /// Standard deviations that are called a bound.
  static constexpr double kSafety = 64;

  explicit MotionError(Eigen::Index n) : covariance_(Eigen::MatrixXd::Zero(n, n)) {}

  /// A step: its matrix (n, n), and what rounding may do to each state.
  void Step(const Eigen::Ref<const Eigen::MatrixXd>& phi, const Eigen::VectorXd& rounding);
  void Event(const EventJump& jump);
  /// A map alone, and an error that comes with it.
  void Map(const Eigen::MatrixXd& map, const Eigen::VectorXd& error);
  /// An error of its own, in the coordinates of the state.
  void Add(const Eigen::VectorXd& error);

  /// Of a number row x.
  [[nodiscard]] double Bound(const Eigen::RowVectorXd& row) const;

 private:
  Eigen::MatrixXd covariance_;
  Eigen::MatrixXd work_;
};

}  // namespace haptometer::sim
