#include "sim/matrix_exponential.h"

#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include "base/error.h"

namespace haptometer::sim {

namespace {

// Scales column i by the power of two that brings it closest to row i; true if that is worth it.
bool BalanceOne(Eigen::Index i, BalancedMatrix& balanced) {
  const double diagonal = std::abs(balanced.matrix(i, i));
  double column = balanced.matrix.col(i).cwiseAbs().sum() - diagonal;
  double row = balanced.matrix.row(i).cwiseAbs().sum() - diagonal;
  if (!(column > 0) || !(row > 0)) return false;
  const double before = column + row;
  double factor = 1;
  while (column < row / 2) {
    column *= 2;
    row /= 2;
    factor *= 2;
  }
  while (column >= 2 * row) {
    column /= 2;
    row *= 2;
    factor /= 2;
  }
  if (column + row >= 0.95 * before) return false;
  balanced.scale(i) *= factor;
  balanced.matrix.col(i) *= factor;
  balanced.matrix.row(i) /= factor;
  return true;
}

}  // namespace

BalancedMatrix Balance(const Eigen::MatrixXd& a) {
  BalancedMatrix balanced{a, Eigen::VectorXd::Ones(a.rows())};
  // each pass lowers the norm by a factor, so this ends
  for (bool changed = true; changed;) {
    changed = false;
    for (Eigen::Index i = 0; i < a.rows(); ++i) changed |= BalanceOne(i, balanced);
  }
  return balanced;
}

Eigen::MatrixXd MatrixExponential(const Eigen::MatrixXd& a) {
  HAPTOMETER_CHECK(a.rows() == a.cols() && a.allFinite(), "({}, {})", a.rows(), a.cols());
  const BalancedMatrix balanced = Balance(a);
  const Eigen::MatrixXd exponential = balanced.matrix.exp();
  // back to the caller's units: D E D^-1
  return balanced.scale.asDiagonal() * exponential * balanced.scale.cwiseInverse().asDiagonal();
}

LongMatrix LongMatrixExponential(const LongMatrix& a, long double t) {
  HAPTOMETER_CHECK(a.rows() == a.cols() && a.allFinite(), "({}, {})", a.rows(), a.cols());
  const Eigen::Matrix<long double, Eigen::Dynamic, 1> scale =
      Balance(a.cast<double>()).scale.cast<long double>();
  const LongMatrix scaled = t * (scale.cwiseInverse().asDiagonal() * a * scale.asDiagonal());
  const LongMatrix exponential = scaled.exp();
  return scale.asDiagonal() * exponential * scale.cwiseInverse().asDiagonal();
}

}  // namespace haptometer::sim
