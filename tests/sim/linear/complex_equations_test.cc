#include "sim/linear/complex_equations.h"

#include <gtest/gtest.h>

#include <complex>
#include <random>

#include "tests/residual.h"

namespace haptometer::sim {
namespace {

using Complex = std::complex<double>;

Eigen::MatrixXcd RandomMatrix(Eigen::Index rows, Eigen::Index columns, std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::MatrixXcd::NullaryExpr(rows, columns,
                                       [&] { return Complex(normal(random), normal(random)); });
}

TEST(Magnitudes, AreThoseOfClosedForms) {
  Eigen::MatrixXcd matrix(2, 2);
  matrix << Complex(3, -4), Complex(0, 5e-100), Complex(-2e150, 0), Complex(0, 0);
  const Eigen::MatrixXd magnitudes = Magnitudes(matrix);
  EXPECT_EQ(magnitudes(0, 0), 5);
  EXPECT_REL(magnitudes(0, 1), 5e-100, 4e-16, "rounding");
  EXPECT_REL(magnitudes(1, 0), 2e150, 4e-16, "rounding");
  EXPECT_EQ(magnitudes(1, 1), 0);
}

TEST(ComplexEquations, OfATwoByTwoAreCramersRule) {
  Eigen::MatrixXcd matrix(2, 2);
  matrix << Complex(1, 2), Complex(0, -1), Complex(3, 0), Complex(2, 2);
  // det = (1 + 2j)(2 + 2j) + 3j = -2 + 9j
  const Complex determinant(-2, 9);
  Eigen::VectorXcd right(2);
  right << Complex(1, 0), Complex(0, 1);
  const ComplexEquations equations(matrix);
  const Eigen::VectorXcd x = equations.Solve(right);
  const Complex first = ((matrix(1, 1) * right(0)) - (matrix(0, 1) * right(1))) / determinant;
  const Complex second = ((matrix(0, 0) * right(1)) - (matrix(1, 0) * right(0))) / determinant;
  EXPECT_ABS(std::abs(x(0) - first), 0, 1e-15, "rounding");
  EXPECT_ABS(std::abs(x(1) - second), 0, 1e-15, "rounding");
  const Eigen::MatrixXd parts = equations.InverseParts();
  ASSERT_EQ(parts.cols(), 4);
  const Complex corner = matrix(0, 0) / determinant;
  EXPECT_ABS(parts(1, 1), corner.real(), 1e-15, "the adjugate over the determinant");
  EXPECT_ABS(parts(1, 3), corner.imag(), 1e-15, "the adjugate over the determinant");
}

TEST(ComplexEquations, SolutionsLeaveNoResidual) {
  std::mt19937 random(1);
  for (Eigen::Index n = 1; n <= 12; ++n) {
    const Eigen::MatrixXcd matrix = RandomMatrix(n, n, random);
    const Eigen::VectorXcd right = RandomMatrix(n, 1, random);
    const ComplexEquations equations(matrix);
    const Eigen::VectorXcd x = equations.Solve(right);
    EXPECT_ABS((matrix * x - right).norm() / (matrix.norm() * x.norm()), 0, 1e-14,
               "backward error of elimination with pivots");
    const Eigen::MatrixXd parts = equations.InverseParts();
    Eigen::MatrixXcd inverse(n, n);
    inverse.real() = parts.leftCols(n);
    inverse.imag() = parts.rightCols(n);
    EXPECT_ABS((inverse * right - x).norm() / x.norm(), 0, 1e-12, "conditions of some 100");
    EXPECT_GT(equations.ReciprocalCondition(), 1e-5);
  }
}

TEST(ComplexEquations, ASingularMatrixHasNoCondition) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 20; ++trial) {
    Eigen::MatrixXcd matrix = RandomMatrix(3, 3, random);
    matrix.row(2) = matrix.row(0);
    EXPECT_FALSE(ComplexEquations(matrix).ReciprocalCondition() > 1e-15);
  }
}

}  // namespace
}  // namespace haptometer::sim
