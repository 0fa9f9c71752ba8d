#include "fit/calibration/straight_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using ::testing::HasSubstr;

// Pearson's points with York's weights, weight = 1 / u^2 (D. York, Can. J. Phys. 44, 1079 (1966))
std::vector<LinePoint> PearsonYork() {
  constexpr double kRows[][4] = {{0.0, 1000, 5.9, 1}, {0.9, 1000, 5.4, 1.8}, {1.8, 500, 4.4, 4},
                                 {2.6, 800, 4.6, 8},  {3.3, 200, 3.5, 20},   {4.4, 80, 3.7, 20},
                                 {5.2, 60, 2.8, 70},  {6.1, 20, 2.8, 70},    {6.5, 1.8, 2.4, 100},
                                 {7.4, 1, 1.5, 500}};
  std::vector<LinePoint> points;
  for (const auto& row : kRows) {
    points.push_back({row[0], row[2], 1 / std::sqrt(row[1]), 1 / std::sqrt(row[3])});
  }
  return points;
}

TEST(StraightLine, PearsonsPointsWithYorksWeights) {
  const auto line = FitStraightLine(PearsonYork(), Scatter::kStated);
  ASSERT_TRUE(line);
  // York et al., Am. J. Phys. 72, 367 (2004), table II
  EXPECT_ABS(line->slope, -0.480533407, 5e-10, "digits printed");
  EXPECT_ABS(line->intercept, 5.47991022, 5e-9, "digits printed");
  EXPECT_ABS(line->slope_uncertainty, 0.0579850090, 5e-11, "digits printed");
  EXPECT_ABS(line->intercept_uncertainty, 0.294970735, 5e-10, "digits printed");
  EXPECT_ABS(line->birge_ratio * line->birge_ratio * 8, 11.8663532, 5e-8, "sum of squares, York");
  EXPECT_FALSE(line->is_beyond_stated);
}

// with exact y the line is the regression of x on y, turned: slope = Syy / Sxy
TEST(StraightLine, ExactReferenceIsTheInverseRegression) {
  std::mt19937_64 engine(3);
  std::normal_distribution<double> noise(0, 0.02);
  std::vector<LinePoint> points;
  double x_mean = 0;
  double y_mean = 0;
  for (int i = 0; i < 12; ++i) {
    points.push_back({i * 0.5 + noise(engine), 1e-3 * i, 0.02, 0});
    x_mean += points.back().x / 12;
    y_mean += points.back().y / 12;
  }
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (const LinePoint& point : points) {
    xx += (point.x - x_mean) * (point.x - x_mean);
    xy += (point.x - x_mean) * (point.y - y_mean);
    yy += (point.y - y_mean) * (point.y - y_mean);
  }
  const auto line = FitStraightLine(points, Scatter::kFromResiduals);
  ASSERT_TRUE(line);
  EXPECT_REL(line->slope, yy / xy, 1e-13, "round-off of sums of 12");
  EXPECT_ABS(line->intercept, y_mean - yy / xy * x_mean, 1e-16, "round-off of 6 mm");
  // u(1/slope) = s / sqrt(Syy), s^2 = (Sxx - Sxy^2 / Syy) / (n - 2); relative u is the same
  const double s = std::sqrt((xx - xy * xy / yy) / 10);
  EXPECT_REL(line->slope_uncertainty / line->slope, s / std::sqrt(yy) * (yy / xy), 1e-12,
             "round-off");
}

// both exact regressions enclose the line of both uncertain (Deming, closed form)
TEST(StraightLine, EqualUncertaintiesAreDemingsLine) {
  std::mt19937_64 engine(5);
  std::normal_distribution<double> noise(0, 0.3);
  std::vector<LinePoint> points;
  for (int i = 0; i < 40; ++i) {
    points.push_back({0.2 * i + noise(engine), 1.5 * 0.2 * i + 1 + 0.5 * noise(engine), 0.3, 0.15});
  }
  double x_mean = 0;
  double y_mean = 0;
  for (const LinePoint& point : points) {
    x_mean += point.x / 40;
    y_mean += point.y / 40;
  }
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (const LinePoint& point : points) {
    xx += (point.x - x_mean) * (point.x - x_mean);
    xy += (point.x - x_mean) * (point.y - y_mean);
    yy += (point.y - y_mean) * (point.y - y_mean);
  }
  // delta = (u(y) / u(x))^2; b = (Syy - delta Sxx + sqrt((...)^2 + 4 delta Sxy^2)) / (2 Sxy)
  const double delta = 0.25;
  const double difference = yy - delta * xx;
  const double slope =
      (difference + std::sqrt(difference * difference + 4 * delta * xy * xy)) / (2 * xy);
  const auto line = FitStraightLine(points, Scatter::kStated);
  ASSERT_TRUE(line);
  EXPECT_REL(line->slope, slope, 1e-13, "round-off");
  EXPECT_REL(line->intercept, y_mean - slope * x_mean, 1e-12, "round-off");
}

// stated and unstated noise: the interval of the slope holds in 95 % of 2000 seeds
TEST(StraightLine, IntervalsHold) {
  for (const Scatter scatter : {Scatter::kStated, Scatter::kFromResiduals}) {
    for (const int n : {4, 7, 21}) {
      int held = 0;
      std::mt19937_64 engine(static_cast<unsigned>(n));
      std::normal_distribution<double> normal;
      for (int seed = 0; seed < 2000; ++seed) {
        std::vector<LinePoint> points;
        for (int i = 0; i < n; ++i) {
          const double volts = 10. * i / (n - 1) - 5;
          points.push_back(
              {volts + 2e-3 * normal(engine), 1e-3 * volts + 1e-6 * normal(engine), 2e-3, 1e-6});
        }
        const auto line = FitStraightLine(points, scatter);
        ASSERT_TRUE(line);
        held += std::abs(line->slope - 1e-3) < line->coverage_95 * line->slope_uncertainty ? 1 : 0;
      }
      // four standard deviations of a binomial of 2000 at 95 %: 39; the 1 % that is widened adds
      EXPECT_NEAR(held, 1900, 45) << n << " points, scatter " << static_cast<int>(scatter);
    }
  }
}

TEST(StraightLine, ScatterBeyondStatedWidens) {
  std::mt19937_64 engine(1);
  std::normal_distribution<double> normal;
  std::vector<LinePoint> points;
  for (int i = 0; i < 10; ++i)
    points.push_back({i * 1., i * 1e-3 + 1e-5 * normal(engine), 0, 1e-6});
  const auto line = FitStraightLine(points, Scatter::kStated);
  const auto free = FitStraightLine(points, Scatter::kFromResiduals);
  ASSERT_TRUE(line && free);
  EXPECT_TRUE(line->is_beyond_stated);
  EXPECT_GT(line->birge_ratio, 5);
  EXPECT_EQ(line->slope_uncertainty, free->slope_uncertainty);
  EXPECT_ABS(line->coverage_95, 2.306004135, 1e-9, "Student's t, 8 degrees of freedom");
}

TEST(StraightLine, CovarianceGivesTheUncertaintyBetweenThePoints) {
  // symmetric points far from 0: at their mean the uncertainty is s / sqrt(n)
  std::vector<LinePoint> points;
  for (const double x : {99., 100., 101., 102.}) points.push_back({x, 2 * x, 0, 0.1});
  const auto line = FitStraightLine(points, Scatter::kStated);
  ASSERT_TRUE(line);
  EXPECT_REL(line->UncertaintyAt(100.5), 0.05, 1e-9, "cancellation of 1e4 squared");
  EXPECT_GT(line->UncertaintyAt(0), 1);
}

TEST(StraightLine, RefusesWhatIsNoLine) {
  const auto error = [](std::vector<LinePoint> points) {
    const auto line = FitStraightLine(points, Scatter::kFromResiduals);
    return line ? "no error" : line.error().Text();
  };
  EXPECT_THAT(error({{0, 0, 1, 0}, {1, 1, 1, 0}}), HasSubstr("2 points"));
  EXPECT_THAT(error({{1, 0, 1, 0}, {1, 1, 1, 0}, {1, 2, 1, 0}}), HasSubstr("are the same"));
  EXPECT_THAT(error({{0, 2, 1, 0}, {1, 2, 1, 0}, {2, 2, 1, 0}}), HasSubstr("are the same"));
  EXPECT_THAT(error({{-1, 1, 1, 0}, {0, 0, 1, 0}, {1, 1, 1, 0}}), HasSubstr("no straight line"));
}

// four points of y = x whose residuals of +-`off` leave the line where it is, y uncertain to 1
std::vector<LinePoint> Scattered(double off) {
  constexpr double kSigns[]{1, -1, -1, 1};
  std::vector<LinePoint> points;
  for (int k = 0; k < 4; ++k) points.push_back({10. * k, 10. * k + off * kSigns[k], 0, 1});
  return points;
}

TEST(StraightLine, ScatterIsBeyondTheStatedFromItsUpperPercentOn) {
  // chi^2 = 4 off^2 with 2 degrees of freedom exceeds -2 ln(0.01) once in 100
  const double limit = std::sqrt(-2 * std::log(0.01) / 4);
  const double of_slope = 1 / std::sqrt(500.0);  // Sxx of 0, 10, 20, 30
  const auto within = FitStraightLine(Scattered(0.998 * limit), Scatter::kStated);
  ASSERT_TRUE(within);
  EXPECT_FALSE(within->is_beyond_stated);
  EXPECT_EQ(within->degrees_of_freedom, 2);
  EXPECT_REL(within->birge_ratio, 0.998 * limit * std::sqrt(2.0), 1e-12, "sqrt(4 off^2 / 2)");
  EXPECT_REL(within->slope_uncertainty, of_slope, 1e-12, "1 / sqrt(Sxx)");
  EXPECT_REL(within->intercept_uncertainty, std::sqrt(1.0 / 4 + 225.0 / 500), 1e-12,
             "1/n + mean^2/Sxx");
  EXPECT_REL(within->covariance, -15.0 / 500, 1e-12, "-mean/Sxx");
  EXPECT_REL(within->coverage_95, 1.959963984540054, 1e-15, "a normal distribution");
  const auto beyond = FitStraightLine(Scattered(1.002 * limit), Scatter::kStated);
  ASSERT_TRUE(beyond);
  EXPECT_TRUE(beyond->is_beyond_stated);
  EXPECT_REL(beyond->slope_uncertainty, of_slope * 1.002 * limit * std::sqrt(2.0), 1e-12,
             "times the Birge ratio");
  EXPECT_REL(beyond->coverage_95, 4.302652729911275, 1e-9, "Student's t, 2 degrees, qt(0.975, 2)");
}

// Four points on the diagonals, equally uncertain in x and y. York's iteration is then that of the
// eigenvector of the larger of the eigenvalues 2 and 2 rate of their scatter: (b - 1)/(b + 1) is
// -rate at the start and falls by `rate` each time.
std::vector<LinePoint> OnDiagonals(double rate) {
  const double root = std::sqrt(rate);
  return {{1, 1, 1, 1}, {-1, -1, 1, 1}, {root, -root, 1, 1}, {-root, root, 1, 1}};
}

TEST(StraightLine, AnIterationThatEndsEarlyMustBeWithinABillionth) {
  // the step behind 200 iterations
  const auto step = [](double rate) { return 2 * std::pow(rate, 201) * (1 - rate); };
  double few = 0.85;
  double many = 0.95;
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = (few + many) / 2;
    (step(middle) < 1e-9 ? few : many) = middle;
  }
  // 1e-4 of the rate is 2 % of the step
  const auto line = FitStraightLine(OnDiagonals(few * (1 - 1e-4)), Scatter::kFromResiduals);
  ASSERT_TRUE(line) << "the last digits still move";
  EXPECT_ABS(line->slope, 1.0, 2e-8, "a step of 1e-9, over 1 less the rate");
  const auto none = FitStraightLine(OnDiagonals(few * (1 + 1e-4)), Scatter::kFromResiduals);
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().Text(), HasSubstr("no straight line"));
}

TEST(StraightLine, PointsWithoutASlopeLieOnNoLine) {
  const auto error = [](const std::vector<LinePoint>& points) {
    const auto line = FitStraightLine(points, Scatter::kFromResiduals);
    return line ? "" : line.error().Text();
  };
  // up and down again: the slope is 0
  EXPECT_THAT(error({{0, 0, 0, 1}, {1, 1, 0, 1}, {2, 0, 0, 1}}), HasSubstr("on no straight line"));
  EXPECT_EQ(error({{0, 0, 0, 1}, {1, 1, 0, 1}, {2, 0.1, 0, 1}}), "");
  // so near to each other that their squares are none
  EXPECT_THAT(error({{0, 0, 0, 1}, {1e-170, 1, 0, 1}, {2e-170, 2, 0, 1}}),
              HasSubstr("on no straight line"));
}

}  // namespace
}  // namespace haptometer::fit
