#include "dsp/statistics/distributions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

TEST(Distributions, AreThoseOfTheirClosedForms) {
  // one degree of freedom: Cauchy; two: t / sqrt(2 + t^2)
  EXPECT_REL(StudentTwoSidedP(3, 1), 1 - 2 * std::atan(3.0) / std::numbers::pi, 1e-15, "rounding");
  EXPECT_REL(StudentTwoSidedP(-3, 2), 1 - 3 / std::sqrt(11.0), 1e-14, "cancels a digit");
  EXPECT_REL(StudentTwoSidedP(1e6, 3), 4 * std::sqrt(3.0) / std::numbers::pi * 1e-18, 1e-11,
             "leading term of the tail: 1.8/t^2 is left out");
  EXPECT_EQ(StudentTwoSidedP(std::numeric_limits<double>::infinity(), 3), 0);
  EXPECT_REL(StudentCritical(7), 2.364624251592784, 1e-14, "printed to 16 digits in R");
  EXPECT_REL(FisherUpperP(9, 1, 5), StudentTwoSidedP(3, 5), 1e-14, "F(1, n) is t^2");
  EXPECT_REL(ChiSquareQuantile(0.5, 2), 2 * std::numbers::ln2, 1e-15, "exponential");
}

TEST(NoncentralityInterval, MirrorsAndIsCentralAtZero) {
  const auto at_zero = NoncentralityInterval(0, 7);
  // T(df, delta) <= 0 is Z + delta <= 0
  EXPECT_REL(at_zero->upper, 1.959963984540054, 1e-12, "normal quantile");
  EXPECT_REL(at_zero->lower, -at_zero->upper, 1e-12, "symmetry");
  const auto right = NoncentralityInterval(6.5, 7);
  const auto left = NoncentralityInterval(-6.5, 7);
  EXPECT_EQ(right->lower, -left->upper);
  EXPECT_EQ(right->upper, -left->lower);
  EXPECT_TRUE(NoncentralityInterval(100, 7).has_value());
  EXPECT_TRUE(NoncentralityInterval(900, 7).has_value());
  EXPECT_FALSE(NoncentralityInterval(1e4, 7).has_value());
  EXPECT_FALSE(NoncentralityInterval(std::numeric_limits<double>::quiet_NaN(), 7).has_value());
}

}  // namespace
}  // namespace haptometer::dsp
