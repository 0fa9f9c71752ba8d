#include "sim/linear/complex_equations.h"

namespace haptometer::sim {
namespace {

// [P, -Q; Q, P] of M = P + jQ
Eigen::MatrixXd RealForm(const Eigen::MatrixXcd& matrix) {
  const Eigen::Index n = matrix.rows();
  Eigen::MatrixXd real(2 * n, 2 * n);
  real.topLeftCorner(n, n) = real.bottomRightCorner(n, n) = matrix.real();
  real.bottomLeftCorner(n, n) = matrix.imag();
  real.topRightCorner(n, n) = -matrix.imag();
  return real;
}

}  // namespace

Eigen::MatrixXd Magnitudes(const Eigen::MatrixXcd& matrix) {
  return matrix.cwiseAbs2().cwiseSqrt();
}

ComplexEquations::ComplexEquations(const Eigen::MatrixXcd& matrix) : factors_(RealForm(matrix)) {}

Eigen::VectorXcd ComplexEquations::Solve(const Eigen::VectorXcd& right) const {
  const Eigen::Index n = right.size();
  Eigen::VectorXd parts(2 * n);
  parts << right.real(), right.imag();
  parts = factors_.solve(parts);
  Eigen::VectorXcd x(n);
  x.real() = parts.head(n);
  x.imag() = parts.tail(n);
  return x;
}

Eigen::MatrixXd ComplexEquations::InverseParts() const {
  // a column b = e_k has no imaginary part
  const Eigen::Index n = factors_.rows() / 2;
  const Eigen::MatrixXd parts = factors_.solve(Eigen::MatrixXd::Identity(2 * n, n));
  Eigen::MatrixXd beside(n, 2 * n);
  beside << parts.topRows(n), parts.bottomRows(n);
  return beside;
}

}  // namespace haptometer::sim
