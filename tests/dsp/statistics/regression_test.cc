#include "dsp/statistics/regression.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "dsp/statistics/distributions.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

TEST(FitLine, IsThatOfAnscombe) {
  // his first set (The American Statistician 27(1), 1973): 3.0 + 0.5 x, R^2 = 0.67,
  // standard error of the slope 0.118
  const std::vector<double> x{10, 8, 13, 9, 11, 14, 6, 4, 12, 7, 5};
  const std::vector<double> y{8.04, 6.95, 7.58, 8.81, 8.33, 9.96, 7.24, 4.26, 10.84, 4.82, 5.68};
  const auto line = FitLine(x, y);
  EXPECT_ABS(line->slope, 0.5, 2e-4, "printed digits");
  EXPECT_ABS(line->intercept, 3.0, 2e-3, "printed digits");
  EXPECT_ABS(line->r_squared, 0.667, 5e-4, "printed digits");
  const double error = (line->slope_interval.upper - line->slope) / StudentCritical(9);
  EXPECT_ABS(error, 0.118, 5e-4, "printed digits");
  EXPECT_FALSE(FitLine(std::vector{1.0, 1.0, 1.0}, std::vector{1.0, 2.0, 3.0}));
  EXPECT_FALSE(FitLine(std::vector{1.0, 2.0}, std::vector{1.0, 2.0}));
  EXPECT_EQ(FitLine(std::vector{1.0, 2.0, 3.0}, std::vector{2.0, 4.0, 6.0})->r_squared, 1);
}

// x beside 1e9, y = 0.3 + 0.1 k rounded, whose deviations from their mean add up to some 1e-16
TEST(FitLine, AnOffsetOfXCostsNoDigits) {
  std::vector<double> x;
  std::vector<double> y;
  for (int k = 0; k < 10; ++k) {
    x.push_back(1e9 + k);
    y.push_back(0.3 + 0.1 * k);
  }
  EXPECT_REL(FitLine(x, y)->slope, 0.1, 1e-14, "rounding of y over 9");
}

TEST(SlopeWithinGroups, IsThatOfEachAboutItsOwnLevel) {
  // slopes of 2 and 4 over x that spread by 2 and 8 in squares: (2 * 2 + 4 * 8) / 10
  const std::vector<Points> groups{{{1, 3}, {100, 104}}, {{10, 14}, {-5, 11}}, {{7}, {1e6}}};
  EXPECT_REL(SlopeWithinGroups(groups).value(), 3.6, 1e-14, "rounding");
  EXPECT_FALSE(SlopeWithinGroups(std::vector<Points>{{{1}, {2}}, {{3, 3}, {4, 5}}, {}}));
}

TEST(FitCurvature, GivesTheParabolaThatThePointsLieOn) {
  const std::vector<double> x{0, 1, 2, 3};
  const std::vector<double> y{5, 8, 15, 26};  // 5 + x + 2 x^2
  const auto bend = FitCurvature(x, y);
  ASSERT_TRUE(bend);
  EXPECT_REL(bend->quadratic, 2, 1e-14, "rounding");
  EXPECT_EQ(bend->df, 1);
}

TEST(FitCurvature, IsNotThrownByAnOffsetOfTheLevels) {
  // x^2 of these has lost the bend's digits; about the mean it has not
  std::vector<double> x;
  std::vector<double> y;
  for (int k = 0; k < 9; ++k) {
    x.push_back(1e6 + k);
    y.push_back(k + 0.25 * k * k);
  }
  EXPECT_REL(FitCurvature(x, y)->quadratic, 0.25, 1e-13, "rounding");
}

TEST(FitCurvature, NeedsFourPointsAndThreeLevels) {
  EXPECT_FALSE(FitCurvature(std::vector{1.0, 2.0, 3.0}, std::vector{1.0, 2.0, 3.0}));
  EXPECT_FALSE(FitCurvature(std::vector{0.1, 0.1, 0.3, 0.3}, std::vector{1.0, 2.0, 3.0, 5.0}));
  EXPECT_FALSE(FitCurvature(std::vector{2.0, 2.0, 2.0, 2.0}, std::vector{1.0, 2.0, 3.0, 5.0}));
}

TEST(FitCurvature, SaysThatAFlatRecordHasNoTest) {
  const auto bend = FitCurvature(std::vector{1.0, 2.0, 3.0, 4.0}, std::vector{3.0, 3.0, 3.0, 3.0});
  ASSERT_TRUE(bend);
  EXPECT_EQ(bend->quadratic, 0);
  EXPECT_FALSE(bend->t);
  EXPECT_FALSE(bend->p);
}

TEST(FitCurvature, HoldsItsInterval) {
  constexpr int kRepetitions = 2000;
  Noise noise(11);
  int held = 0;
  int found = 0;
  for (int k = 0; k < kRepetitions; ++k) {
    std::vector<double> x;
    std::vector<double> y;
    for (int i = 1; i <= 6; ++i) {
      x.push_back(i);
      y.push_back(8 * i - 0.1 * i * i + 0.2 * noise());
    }
    const auto bend = FitCurvature(x, y);
    held += bend->interval.lower <= -0.1 && -0.1 <= bend->interval.upper ? 1 : 0;
    for (std::size_t i = 0; i < x.size(); ++i) y[i] += 0.1 * x[i] * x[i];
    found += *FitCurvature(x, y)->p < 0.05 ? 1 : 0;
  }
  EXPECT_ABS(static_cast<double>(held) / kRepetitions, 0.95, 0.02, "the bar");
  EXPECT_ABS(static_cast<double>(found) / kRepetitions, 0.05, 0.02, "three standard deviations");
}

// x = 1 2 3 4, y = 1 3 2 4: slope 4/5, residuals -0.3, 0.9, -0.9, 0.3, so s^2 = 0.9; the quantile
// of two degrees of freedom is 0.95 sqrt(2 / (1 - 0.95^2))
TEST(FitLine, HasTheIntervalsOfTheClosedForm) {
  const auto line = FitLine(std::vector{1.0, 2.0, 3.0, 4.0}, std::vector{1.0, 3.0, 2.0, 4.0});
  ASSERT_TRUE(line);
  const double t = 0.95 * std::sqrt(2 / (1 - 0.95 * 0.95));
  const double of_slope = t * std::sqrt(0.9 / 5);
  const double of_intercept = t * std::sqrt(0.9 * (1.0 / 4 + 2.5 * 2.5 / 5));
  EXPECT_REL(line->slope_interval.lower, 0.8 - of_slope, 1e-13, "rounding");
  EXPECT_REL(line->slope_interval.upper, 0.8 + of_slope, 1e-13, "rounding");
  EXPECT_REL(line->intercept_interval.lower, 0.5 - of_intercept, 1e-13, "rounding");
  EXPECT_REL(line->intercept_interval.upper, 0.5 + of_intercept, 1e-13, "rounding");
  EXPECT_REL(line->r_squared, 0.64, 1e-14, "rounding");
  EXPECT_REL(line->residual_deviation, std::sqrt(0.9), 1e-14, "rounding");
  EXPECT_REL(line->largest_deviation, 0.9, 1e-14, "rounding");
}

// 0.5 (x^2 - 2) and a cubic that is orthogonal to every parabola over -2 .. 2, of 10 in squares:
// s^2 = 10 / 2, sum(q^2) = 14
TEST(FitCurvature, HasTheTestOfTheClosedForm) {
  const std::vector<double> x{-2, -1, 0, 1, 2};
  const std::vector<double> y{1 - 1, -0.5 + 2, -1, -0.5 - 2, 1 + 1};
  const auto bend = FitCurvature(x, y);
  ASSERT_TRUE(bend && bend->t && bend->p);
  const double u = std::sqrt(5.0 / 14);
  const double t = 0.5 / u;
  EXPECT_REL(bend->quadratic, 0.5, 1e-14, "rounding");
  EXPECT_EQ(bend->df, 2);
  EXPECT_REL(*bend->t, t, 1e-13, "rounding");
  EXPECT_REL(*bend->p, 1 - t / std::sqrt(2 + t * t), 1e-13, "closed form");
  const double reach = 0.95 * std::sqrt(2 / (1 - 0.95 * 0.95)) * u;
  EXPECT_REL(bend->interval.lower, 0.5 - reach, 1e-13, "rounding of the quantile");
  EXPECT_REL(bend->interval.upper, 0.5 + reach, 1e-13, "rounding of the quantile");
}

TEST(RegressionDeathTest, TakesAsManyXAsY) {
  const std::vector<double> three{1, 2, 4};
  const std::vector<double> four{1, 2, 4, 5};
  EXPECT_DEATH(static_cast<void>(FitLine(three, four)), "check failed");
  const std::vector<Points> groups{{three, four}};
  EXPECT_DEATH(static_cast<void>(SlopeWithinGroups(groups)), "check failed");
}

}  // namespace
}  // namespace haptometer::dsp
