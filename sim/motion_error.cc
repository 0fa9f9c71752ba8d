#include "sim/motion_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptometer::sim {

namespace {

// of the guard's error over g'^2/(2 |g''|), up to which an event is moved but not changed
constexpr double kLinearPart = 0.05;

}  // namespace

void MotionError::Step(const Eigen::Ref<const Eigen::MatrixXd>& phi,
                       const Eigen::VectorXd& rounding) {
  // products of so few rows are faster without blocks
  work_.noalias() = phi.lazyProduct(covariance_);
  covariance_.noalias() = work_.lazyProduct(phi.transpose());
  covariance_.diagonal() += rounding.cwiseAbs2();
}

void MotionError::Add(const Eigen::VectorXd& error) {
  covariance_.noalias() += error * error.transpose();
}

void MotionError::Map(const Eigen::MatrixXd& map, const Eigen::VectorXd& error) {
  covariance_ = (map * covariance_ * map.transpose()).eval();
  Add(error);
}

void MotionError::Event(const EventJump& jump) {
  const Eigen::VectorXd rate_step = jump.rate_after - jump.map * jump.rate_before;
  const double error = Bound(jump.guard), speed = std::abs(jump.guard_rate);
  const double bend = std::abs(jump.guard_curvature);
  if (2 * error * bend <= kLinearPart * speed * speed && speed > 0) {
    const Eigen::VectorXd by_guard = rate_step / jump.guard_rate;
    Map(jump.map + by_guard * jump.guard, jump.guard_rounding * by_guard);
    return;
  }
  // the time may be off by that, and what jumps may not
  double time_s = bend > 0 ? std::sqrt(2 * error / bend) : error / speed;
  if (!std::isfinite(time_s)) time_s = 0;
  Map(jump.map, 2 * time_s / kSafety * rate_step);
  if (jump.step_of_state.size() > 0) Add(jump.step_of_state / kSafety);
}

double MotionError::Bound(const Eigen::RowVectorXd& row) const {
  const double square = row.dot(covariance_ * row.transpose());
  if (!std::isfinite(square)) return std::numeric_limits<double>::infinity();
  return kSafety * std::sqrt(std::max(square, 0.0));
}

}  // namespace haptometer::sim
