#include "sim/linear/driven_step.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>

#include "base/circular_functions.h"
#include "base/error.h"
#include "sim/linear/excitation.h"
#include "sim/linear/mode.h"

namespace haptometer::sim {
namespace {

// Scales column i by the power of two that brings it closest to row i; true if that is worth it.
bool BalanceOne(Eigen::Index i, BalancedMatrix& balanced) {
  const double diagonal = std::abs(balanced.matrix(i, i));
  double column = balanced.matrix.col(i).cwiseAbs().sum() - diagonal;
  double row = balanced.matrix.row(i).cwiseAbs().sum() - diagonal;
  if (!(column > 0) || !(row > 0)) return false;
  const double before = column + row;
  // powers of two scale without rounding
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
  // less than 5 % gained ends the balancing (Parlett and Reinsch 1969)
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
  // the scale needs no long digits: it consists of powers of two
  const Eigen::Matrix<long double, Eigen::Dynamic, 1> scale =
      Balance(a.cast<double>()).scale.cast<long double>();
  const LongMatrix scaled = t * (scale.cwiseInverse().asDiagonal() * a * scale.asDiagonal());
  const LongMatrix exponential = scaled.exp();
  return scale.asDiagonal() * exponential * scale.cwiseInverse().asDiagonal();
}

namespace {

// [E, V R^-1] out of exp(G h)
template <typename Matrix>
Matrix StepOf(const Matrix& exponential, Eigen::Index signals) {
  Matrix step = exponential.topRows(exponential.rows() - signals);
  // two signals are the usual case: a fixed size avoids the general inverse
  if (signals == 2) {
    const auto turn = exponential.bottomRightCorner(2, 2).inverse().eval();
    step.rightCols(2) = (step.rightCols(2) * turn).eval();
    return step;
  }
  const Matrix turn = exponential.bottomRightCorner(signals, signals).inverse();
  step.rightCols(signals) = (step.rightCols(signals) * turn).eval();
  return step;
}

}  // namespace

Eigen::MatrixXd DrivenGenerator(const Eigen::MatrixXd& a, const Eigen::MatrixXd& inputs,
                                const ExcitationShape& shape) {
  const Eigen::Index n = a.rows(), m = shape.generator.rows();
  // G = [A, B rows; 0, S], so that z' = G z with z = [x, w]
  Eigen::MatrixXd generator = Eigen::MatrixXd::Zero(n + m, n + m);
  generator.topLeftCorner(n, n) = a;
  generator.topRightCorner(n, m) = inputs * shape.rows;
  generator.bottomRightCorner(m, m) = shape.generator;
  return generator;
}

LongMatrix LongDrivenGenerator(const Mode& mode, const ExcitationShape& shape) {
  const Eigen::Index n = mode.a.rows(), m = shape.generator.rows();
  LongMatrix inputs = mode.Inputs().cast<long double>();
  inputs.col(kVoltage) += mode.b_rest.cast<long double>();
  LongMatrix generator = DrivenGenerator(mode.a, mode.Inputs(), shape).cast<long double>();
  generator.topLeftCorner(n, n) += mode.a_rest.cast<long double>();
  generator.topRightCorner(n, m) = inputs * shape.rows.cast<long double>();
  return generator;
}

Eigen::Vector2d DriveAt(double frequency_hz, long double t_s) {
  // whole cycles are subtracted in 64 bits before the sine; rint, unlike nearbyint, is one
  // instruction
  const long double cycles = static_cast<long double>(frequency_hz) * t_s;
  const double phase_rad = 2 * std::numbers::pi * static_cast<double>(cycles - std::rint(cycles));
  const SineAndCosine drive = SinCos(phase_rad);
  return {drive.sine, drive.cosine};
}

Eigen::MatrixXd DrivenStep(const Eigen::MatrixXd& generator, double h_s, Eigen::Index signals) {
  return StepOf<Eigen::MatrixXd>(MatrixExponential(h_s * generator), signals);
}

LongMatrix LongDrivenStep(const LongMatrix& generator, long double h_s, Eigen::Index signals) {
  return StepOf<LongMatrix>(LongMatrixExponential(generator, h_s), signals);
}

DriveSequence::DriveSequence(double frequency_hz, double start_s, double rate_hz)
    : frequency_hz_(frequency_hz),
      start_s_(static_cast<long double>(start_s)),
      rate_hz_(static_cast<long double>(rate_hz)) {
  for (std::size_t k = 0; k < kTurns; ++k) {
    turns_[k] = DriveAt(frequency_hz, static_cast<long double>(k) / rate_hz_);
  }
  Begin(0);
}

void DriveSequence::Begin(std::uint64_t sample) {
  begin_sample_ = sample;
  begin_ = DriveAt(frequency_hz_, start_s_ + static_cast<long double>(sample) / rate_hz_);
}

}  // namespace haptometer::sim
