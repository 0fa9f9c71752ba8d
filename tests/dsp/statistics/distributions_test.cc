#include "dsp/statistics/distributions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <numbers>
#include <string>

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

// SciPy's noncentral t, at 12 numbers of subjects and 5 of tests
TEST(NoncentralityForPower, IsThatOfScipy) {
  std::ifstream file(HAPTOMETER_FIXTURES "/../tests/dsp/statistics/power_reference.csv");
  std::string line;
  int rows = 0;
  while (std::getline(file, line)) {
    int subjects = 0;
    int tests = 0;
    double effect = 0;
    if (std::sscanf(line.c_str(), "%d,%d,%lg", &subjects, &tests, &effect) != 3) continue;
    ++rows;
    const auto found = NoncentralityForPower(subjects - 1, 0.05 / tests, 0.8);
    EXPECT_REL(found.value() / std::sqrt(subjects), effect, 1e-8, "SciPy's distribution");
  }
  EXPECT_EQ(rows, 60);
  EXPECT_FALSE(NoncentralityForPower(1, 1e-4, 0.8)) << "a critical t of 6366";
  // of half a degree of freedom the critical t is 693 and 721, the limit 1000 sqrt(0.5)
  EXPECT_TRUE(NoncentralityForPower(0.5, 0.02436546, 0.8));
  EXPECT_FALSE(NoncentralityForPower(0.5, 0.02388293, 0.8));
}

// the limits of what can be computed: |t| of 1000, and of 1000 sqrt(df)
TEST(NoncentralityInterval, EndsAtTheStatedLimits) {
  EXPECT_TRUE(NoncentralityInterval(999, 9).has_value());
  EXPECT_FALSE(NoncentralityInterval(1001, 9).has_value());
  EXPECT_TRUE(NoncentralityInterval(499, 0.25).has_value());
  EXPECT_FALSE(NoncentralityInterval(501, 0.25).has_value());
}

// the share of both tails beyond the critical value is the power that was asked for
TEST(NoncentralityForPower, OfManyDegreesOfFreedomIsThatOfANormalVariable) {
  const auto delta = NoncentralityForPower(1e6, 0.05, 0.8);
  ASSERT_TRUE(delta);
  const auto below = [](double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); };
  const double power = below(*delta - 1.959963984540054) + below(-*delta - 1.959963984540054);
  EXPECT_ABS(power, 0.8, 3e-6, "t of 1e6 degrees of freedom is normal to 1e-6");
}

TEST(DistributionsDeathTest, RefuseWhatTheyAreNotDefinedFor) {
  EXPECT_DEATH(static_cast<void>(StudentTwoSidedP(1, 0)), "check failed");
  EXPECT_DEATH(static_cast<void>(StudentCritical(0)), "check failed");
  EXPECT_DEATH(static_cast<void>(FisherUpperP(-1e-9, 1, 5)), "check failed");
  EXPECT_DEATH(static_cast<void>(FisherUpperP(1, 0, 5)), "check failed");
  EXPECT_DEATH(static_cast<void>(FisherUpperP(1, 1, 0)), "check failed");
  EXPECT_EQ(FisherUpperP(0, 1, 5), 1);
  for (const double p : {0.0, 1.0}) {
    EXPECT_DEATH(static_cast<void>(FisherQuantile(p, 1, 5)), "check failed") << p;
    EXPECT_DEATH(static_cast<void>(ChiSquareQuantile(p, 2)), "check failed") << p;
  }
  EXPECT_DEATH(static_cast<void>(FisherQuantile(0.5, 0, 5)), "check failed");
  EXPECT_DEATH(static_cast<void>(FisherQuantile(0.5, 1, 0)), "check failed");
  EXPECT_DEATH(static_cast<void>(ChiSquareQuantile(0.5, 0)), "check failed");
  EXPECT_DEATH(static_cast<void>(NoncentralityInterval(1, 0)), "check failed");
  EXPECT_DEATH(static_cast<void>(NoncentralityForPower(0, 0.05, 0.8)), "check failed");
  EXPECT_DEATH(static_cast<void>(NoncentralityForPower(9, 0, 0.8)), "check failed");
  EXPECT_DEATH(static_cast<void>(NoncentralityForPower(9, 0.05, 0.05)), "check failed");
  EXPECT_DEATH(static_cast<void>(NoncentralityForPower(9, 0.05, 1)), "check failed");
}

}  // namespace
}  // namespace haptometer::dsp
