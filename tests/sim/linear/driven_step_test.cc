#include "sim/linear/driven_step.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "sim/linear/linear_model.h"
#include "tests/residual.h"
#include "tests/sim/reference/linear_reference.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

Eigen::MatrixXd Matrix(std::initializer_list<std::initializer_list<double>> rows) {
  return Eigen::MatrixXd(rows);
}

// largest error over the norm, in balanced units: there all entries are of one kind
double NormwiseError(const Eigen::MatrixXd& a, const Eigen::MatrixXd& actual,
                     const Eigen::MatrixXd& expected) {
  const Eigen::VectorXd d = Balance(a).scale;
  const auto in_units = [&](const Eigen::MatrixXd& m) {
    return (d.cwiseInverse().asDiagonal() * m * d.asDiagonal()).eval();
  };
  return in_units(actual - expected).cwiseAbs().colwise().sum().maxCoeff() /
         in_units(expected).cwiseAbs().colwise().sum().maxCoeff();
}

TEST(Balancing, IsASimilarityByPowersOfTwo) {
  const Eigen::MatrixXd a = AssembleModel(tests::AdapterScene()).a;
  const BalancedMatrix balanced = Balance(a);
  for (const double d : balanced.scale) {
    int exponent = 0;
    EXPECT_EQ(std::frexp(d, &exponent), 0.5) << d;
  }
  // no rounding, so back again to the last bit
  const Eigen::MatrixXd back =
      balanced.scale.asDiagonal() * balanced.matrix * balanced.scale.cwiseInverse().asDiagonal();
  EXPECT_EQ(back, a);
  // 1.68e7 in SI units
  EXPECT_LT(balanced.matrix.cwiseAbs().colwise().sum().maxCoeff(), 2.2e5);
}

// a change of units leaves the diagonal as it is, so it does not count
TEST(Balancing, CountsNoDiagonal) {
  const Eigen::MatrixXd even = Matrix({{1000, 1}, {1, -1000}});
  EXPECT_EQ(Balance(even).matrix, even);
  const BalancedMatrix balanced = Balance(Matrix({{3, 64}, {1, 5}}));
  EXPECT_EQ(balanced.matrix, Matrix({{3, 8}, {8, 5}}));
  EXPECT_EQ(balanced.scale(0), 8 * balanced.scale(1));
}

TEST(DriveSequence, GivesTheSineOfAnySampleInAnyOrder) {
  constexpr double kStartS = 0.0123;
  DriveSequence sequence(225, kStartS, 1e4);
  for (const std::uint64_t sample : {0U, 31U, 32U, 33U, 1000003U, 5U, 64U}) {
    const long double cycles =
        225 * (static_cast<long double>(kStartS) + static_cast<long double>(sample) / 1e4L);
    const auto part = static_cast<double>(cycles - std::round(cycles));
    const Eigen::Vector2d drive = sequence.At(sample);
    // the turn of two phases, and cycles of 64 bits
    const double bar = 2e-15 + 2 * std::numbers::pi * 0x1p-63 * static_cast<double>(cycles);
    EXPECT_ABS(drive[0], std::sin(2 * std::numbers::pi * part), bar, "rounding");
    EXPECT_ABS(drive[1], std::cos(2 * std::numbers::pi * part), bar, "rounding");
  }
}

TEST(MatrixExponential, OfMolersMatrix) {
  const double a = 2e10, b = 4e8 / 6, c = 200.0 / 3, d = 3, e = 1e-8;
  const Eigen::MatrixXd moler = Matrix({{0, e, 0}, {-(a + b), -d, a}, {c, 0, -c}});
  const Eigen::MatrixXd actual = MatrixExponential(moler);
  const char* printed = "C. Moler, A Balancing Act for the Matrix Exponential, 2012, six digits";
  EXPECT_REL(actual(0, 0), 0.446849, 1.1e-6, printed);
  EXPECT_REL(actual(0, 1), 1.54044e-9, 1.1e-6, printed);
  EXPECT_REL(actual(0, 2), 0.462811, 1.1e-6, printed);
  for (Eigen::Index i = 0; i < 9; ++i) {
    EXPECT_REL(actual(i / 3, i % 3), tests::kMolerExponential[i], 1e-13,
               "nine squarings of a matrix whose entries nearly cancel");
  }
}

TEST(MatrixExponential, OfTheThesisModelAgreesWithFiftyDigits) {
  const Eigen::MatrixXd a = AssembleModel(tests::AdapterScene()).a;
  for (const tests::ExponentialReference& reference : tests::kExponentials) {
    const Eigen::MatrixXd expected =
        Eigen::Map<const Eigen::Matrix<double, 7, 7, Eigen::RowMajor>>(reference.entries);
    const double error = NormwiseError(a, MatrixExponential(a * reference.h_s), expected);
    // rounding gathers with the squarings, 1 at 1e-5 s and 13 at 0.1 s, as chance has it: 1.4e-12
    // sqrt(h) where products are fused (AArch64), below 1e-12 sqrt(h) on x86-64
    const double bound = 2e-12 * std::sqrt(reference.h_s);
    EXPECT_ABS(error, 0, bound, "rounding grows with the number of squarings");
  }
}

TEST(MatrixExponential, OfClosedForms) {
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(3, 3);
  EXPECT_EQ(MatrixExponential(Eigen::MatrixXd::Zero(3, 3)), identity);
  // rotation
  const double angle = 0.7;
  const Eigen::MatrixXd rotation = MatrixExponential(Matrix({{0, angle}, {-angle, 0}}));
  EXPECT_REL(rotation(0, 0), std::cos(angle), 4e-16, "one rounding");
  EXPECT_REL(rotation(0, 1), std::sin(angle), 4e-16, "one rounding");
  // a defective matrix, where eigenvectors fail: critical damping, exp = e^-p [[1+p, 1], [-pp,
  // 1-p]]
  const double p = 3;
  const Eigen::MatrixXd critical = MatrixExponential(Matrix({{0, 1}, {-p * p, -2 * p}}));
  EXPECT_REL(critical(0, 0), std::exp(-p) * (1 + p), 3e-15, "four squarings");
  EXPECT_REL(critical(0, 1), std::exp(-p), 3e-15, "four squarings");
  EXPECT_REL(critical(1, 0), -std::exp(-p) * p * p, 3e-15, "four squarings");
  // the shape of a coil: SciPy 1.10's own form for two rows gives NaN here (scipy issue 19584)
  const Eigen::MatrixXd stiff = MatrixExponential(Matrix({{-247, 0}, {6283, -6283}}));
  EXPECT_REL(stiff(1, 0), 6283.0 / (6283 - 247) * std::exp(-247.0), 1e-12, "twelve squarings");
}

// not by halves: twice the time only adds a squaring to the same approximant
TEST(MatrixExponential, OfASumOfTimesIsTheProduct) {
  const Eigen::MatrixXd a = AssembleModel(tests::AdapterScene()).a;
  for (const double h_s : {1e-7, 1e-5, 1e-3, 3e-2}) {
    const Eigen::MatrixXd parts = MatrixExponential(a * (0.3 * h_s)) * MatrixExponential(a * h_s);
    const double error = NormwiseError(a, parts, MatrixExponential(a * (1.3 * h_s)));
    EXPECT_ABS(error, 0, 1e-15 + 2e-12 * std::sqrt(h_s), "twice the bound of one exponential");
  }
}

TEST(MatrixExponential, OfADecoupledStateLeavesItAlone) {
  // a zero row and column must neither stop the balancing nor be scaled
  const Eigen::MatrixXd e = MatrixExponential(Matrix({{-1, 0, 1e6}, {0, 0, 0}, {1e-6, 0, -2}}));
  EXPECT_REL(e(1, 1), 1.0, 3e-16, "one rounding");
  EXPECT_EQ(e(0, 1), 0);
  EXPECT_EQ(e(1, 2), 0);
  EXPECT_REL(e(0, 2) * 1e-6, e(2, 0) * 1e6, 1e-15, "the similar matrix is symmetric");
}

TEST(MatrixExponentialDeath, RefusesWhatIsNotANumber) {
  EXPECT_DEATH(
      static_cast<void>(MatrixExponential(Matrix({{std::numeric_limits<double>::quiet_NaN()}}))),
      "check failed");
}

}  // namespace
}  // namespace haptometer::sim
