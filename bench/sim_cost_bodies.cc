#include "bench/sim_cost_bodies.h"

namespace haptometer::sim {

Eigen::MatrixXd LinearPart(const Question& question, bool contact) {
  const auto n = static_cast<Eigen::Index>(question.states());
  Question linear = question;
  linear.cubic_n_per_m3 = 0;
  // around rest, so that the preload's constant and the products vanish
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(n);
  Eigen::VectorXd constant(n);
  RateOf(linear, contact, 0.0, rest.data(), constant.data());
  Eigen::MatrixXd matrix(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(n, k);
    RateOf(linear, contact, 0.0, unit.data(), matrix.col(k).data());
  }
  matrix.colwise() -= constant;
  // i^2 of the unit current
  if (question.heat_capacity_j_per_k > 0) matrix(kEighth, kCurrent) = 0;
  return matrix;
}

void JacobianAt(const Question& question, const Eigen::MatrixXd& linear, const double* y,
                double* jacobian) {
  Eigen::Map<Eigen::MatrixXd> out(jacobian, linear.rows(), linear.cols());
  out = linear;
  const Bodies& b = question.bodies;
  const double d = y[kXv] - y[kXa] + question.sag_m;
  const double stiffness = 3 * question.cubic_n_per_m3 * d * d;
  out(kVv, kXv) -= stiffness / b.Mv;
  out(kVv, kXa) += stiffness / b.Mv;
  out(kVa, kXv) += stiffness / (b.Mc + b.Ma1);
  out(kVa, kXa) -= stiffness / (b.Mc + b.Ma1);
  if (!(question.heat_capacity_j_per_k > 0)) return;
  const double i = y[kCurrent], rise = kRisePerK * y[kEighth];
  out(kCurrent, kCurrent) -= b.R * rise / b.L;
  out(kCurrent, kEighth) -= b.R * kRisePerK * i / b.L;
  out(kEighth, kCurrent) += 2 * b.R * (1 + rise) * i / question.heat_capacity_j_per_k;
  out(kEighth, kEighth) += b.R * kRisePerK * i * i / question.heat_capacity_j_per_k;
}

}  // namespace haptometer::sim
