#include "fit/calibration/calibration_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <utility>
#include <vector>

#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using ::testing::ElementsAre;

// n points over +-5 V of 1 mm/V, up and then down, with noise of 1 mV; `bend` and `gap` in m
std::vector<LinePoint> Points(unsigned seed, int n, double bend = 0, double gap = 0,
                              double noise_v = 1e-3) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> noise(0, noise_v);
  std::vector<LinePoint> points;
  for (int i = 0; i < n; ++i) {
    const int half = (n + 1) / 2;
    const bool is_rising = i < half;
    const double z = -1 + 2. * (is_rising ? i : n - 1 - i) / (half - 1);
    const double volts = 5 * z - 1e3 * bend * (z * z * z - 0.6 * z) + (is_rising ? 0 : 1e3 * gap);
    points.push_back({volts + noise(engine), 5e-3 * z, noise_v, 0});
  }
  return points;
}

TEST(CalibrationFit, NoiseIsSeldomTakenForACurveOrHysteresis) {
  int curved = 0;
  int hysteresis = 0;
  for (unsigned seed = 0; seed < 2000; ++seed) {
    const auto fit = FitCalibration(Points(seed, 21), Scatter::kFromResiduals);
    ASSERT_TRUE(fit);
    curved += fit->is_curved ? 1 : 0;
    hysteresis += fit->hysteresis->is_significant ? 1 : 0;
  }
  // 1 % of 2000 and four standard deviations; three standard uncertainties of few points
  EXPECT_NEAR(curved, 20, 18);
  EXPECT_LT(hysteresis, 40);
}

// noise of 30 mV, so that not even its usual distances are below a thousandth of the range
TEST(CalibrationFit, NoiseIsSeldomTakenForAnOutlier) {
  for (const Scatter scatter : {Scatter::kFromResiduals, Scatter::kStated}) {
    for (const int n : {4, 5, 6, 8, 9, 21}) {
      int outliers = 0;
      for (unsigned seed = 0; seed < 1000; ++seed) {
        outliers += FitCalibration(Points(seed, n, 0, 0, 30e-3), scatter)->outliers ? 1 : 0;
      }
      std::printf("%2d points: %d of 1000\n", n, outliers);
      // 1.1 % of 1000 at most and four standard deviations
      EXPECT_LT(outliers, 25) << n;
    }
  }
}

TEST(CalibrationFit, ATypingErrorIsAnOutlierWithTheLineOfTheOthers) {
  for (const Scatter scatter : {Scatter::kFromResiduals, Scatter::kStated}) {
    // 1.00 V written as 10.0 V, at either end and in the middle
    for (const std::size_t wrong : {std::size_t{0}, std::size_t{3}, std::size_t{8}}) {
      auto points = Points(7, 9);
      const auto right = FitCalibration(points, scatter);
      points[wrong].x += 9;
      const auto fit = FitCalibration(points, scatter);
      ASSERT_TRUE(fit && fit->outliers) << wrong;
      ASSERT_EQ(fit->outliers->points.size(), 1U) << wrong;
      EXPECT_EQ(fit->outliers->points[0].point, wrong);
      EXPECT_ABS(fit->outliers->points[0].distance, -9e-3, 20e-6, "noise of 1 um, extrapolated");
      EXPECT_REL(fit->outliers->others.slope, right->line.slope, 1e-3, "noise of 8 points");
      EXPECT_LT(fit->outliers->scatter, 4e-6) << "noise of 1 um";
      // and no curve
      EXPECT_FALSE(fit->is_curved) << wrong;
    }
  }
  // what stated uncertainties explain is none
  auto wide = Points(7, 9);
  wide[3].x += 9;
  wide[3].x_uncertainty = 10;
  EXPECT_FALSE(FitCalibration(wide, Scatter::kStated)->outliers);
  // a curve alone has none
  for (const double bend : {5e-6, 20e-6, 200e-6}) {
    for (const int n : {7, 9, 21}) {
      for (unsigned seed = 0; seed < 100; ++seed) {
        EXPECT_FALSE(FitCalibration(Points(seed, n, bend), Scatter::kFromResiduals)->outliers)
            << bend << ' ' << n << ' ' << seed;
      }
    }
  }
}

// 12 standard deviations in the middle of 21 points
TEST(CalibrationFit, ASmallErrorAmongManyPointsIsNamed) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    auto points = Points(seed, 21, 0, 0, 5e-3);
    points[5].x += 60e-3;
    const auto fit = FitCalibration(points, Scatter::kFromResiduals);
    ASSERT_TRUE(fit && fit->outliers) << seed;
    EXPECT_TRUE(std::ranges::count(fit->outliers->points, 5U, &Outlier::point)) << seed;
  }
}

// any one of few rows, by a digit more or less, in either column
TEST(CalibrationFit, AGrossErrorOfAnyOfFewRowsIsNamed) {
  for (const int n : {5, 6, 7}) {
    for (std::size_t wrong = 0; wrong < static_cast<std::size_t>(n); ++wrong) {
      for (const double error_v : {-30., -9., -1., 1., 9., 30.}) {
        for (const bool is_reference : {false, true}) {
          auto points = Points(11, n);
          (is_reference ? points[wrong].y : points[wrong].x) += error_v * (is_reference ? 1e-3 : 1);
          const auto fit = FitCalibration(points, Scatter::kFromResiduals);
          ASSERT_TRUE(fit && fit->outliers) << n << ' ' << wrong << ' ' << error_v;
          ASSERT_EQ(fit->outliers->points.size(), 1U) << n << ' ' << wrong << ' ' << error_v;
          EXPECT_EQ(fit->outliers->points[0].point, wrong) << n << ' ' << error_v;
        }
      }
    }
  }
}

// two that pull the line the same way, or against each other
TEST(CalibrationFit, TwoTypingErrorsDoNotHideEachOther) {
  for (const int n : {7, 9, 21}) {
    for (const auto& [one_v, other_v] :
         {std::pair(9., 9.), std::pair(9., -9.), std::pair(3., 5.)}) {
      for (std::size_t one = 0; one + 1 < static_cast<std::size_t>(n); ++one) {
        auto points = Points(5, n);
        points[one].x += one_v;
        points[one + 1].x += other_v;
        const auto fit = FitCalibration(points, Scatter::kFromResiduals);
        ASSERT_TRUE(fit && fit->outliers) << n << ' ' << one << ' ' << one_v << ' ' << other_v;
        ASSERT_EQ(fit->outliers->points.size(), 2U) << n << ' ' << one;
        EXPECT_EQ(fit->outliers->points[0].point, one);
        EXPECT_EQ(fit->outliers->points[1].point, one + 1);
        EXPECT_FALSE(fit->is_curved) << n << ' ' << one;
      }
    }
  }
}

TEST(CalibrationFit, RoundingOfExactPointsIsNoOutlier) {
  std::vector<LinePoint> points;
  for (int i = 0; i < 7; ++i) points.push_back({1. * i, i + (i == 3 ? 1e-3 : 0), 1, 0});
  EXPECT_FALSE(FitCalibration(points, Scatter::kFromResiduals)->outliers);
  points[3].y += 0.1;
  const auto fit = FitCalibration(points, Scatter::kFromResiduals);
  ASSERT_TRUE(fit->outliers);
  ASSERT_EQ(fit->outliers->points.size(), 1U);
  EXPECT_ABS(fit->outliers->points[0].distance, 0.101, 1e-12, "round-off");
}

TEST(CalibrationFit, ACurveWidensTheSlope) {
  // residual: bend (z^3 - 0.6 z), orthogonal to a line; its slope bend (3 z^2 - 0.6) over 5 mm has
  // the mean square bend^2 (9 / 5 - 1.2 + 0.36)
  const double bend = 20e-6;
  const auto fit = FitCalibration(Points(1, 401, bend), Scatter::kFromResiduals);
  ASSERT_TRUE(fit);
  EXPECT_TRUE(fit->is_curved);
  const double rms = std::sqrt(0.96) * bend / 5e-3;
  EXPECT_REL(fit->local_slope_uncertainty, rms, 0.03,
             "noise of 401 points of 1 um: 0.7 um / sqrt(401) a coefficient");
  EXPECT_GT(fit->relative_uncertainty, fit->local_slope_uncertainty);
  // largest deviation: 0.4 bend at the ends, and noise of 1 um
  EXPECT_ABS(fit->nonlinearity, 0.4 * bend, 4e-6, "four standard deviations of noise");
}

// n points over +-5 V of 1 mm/V in rising order, noise of 3 mV, and a step before one of them
std::vector<LinePoint> Slipped(unsigned seed, int n, int first, double step_m) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> noise(0, 3e-3);
  std::vector<LinePoint> points;
  for (int i = 0; i < n; ++i) {
    const double volts = -5 + 10. * i / (n - 1);
    points.push_back({volts + noise(engine), 1e-3 * volts + (i < first ? 0 : step_m), 3e-3, 0});
  }
  return points;
}

TEST(CalibrationFit, ASlipIsFoundWhereItIsWithTheGainOfTwoLines) {
  for (const int n : {9, 21, 40}) {
    int found = 0;
    for (unsigned seed = 0; seed < 100; ++seed) {
      const auto fit = FitCalibration(Slipped(seed, n, n / 2, 30e-6), Scatter::kFromResiduals);
      ASSERT_TRUE(fit);
      if (!fit->slip) continue;
      ++found;
      EXPECT_EQ(fit->slip->point, static_cast<std::size_t>(n / 2)) << seed;
      // 3 um of noise a point: the step's standard uncertainty is below 6 um, the gain's 0.2 %
      EXPECT_NEAR(fit->slip->step, 30e-6, 24e-6);
      EXPECT_NEAR(fit->slip->slope, 1e-3, 8e-6);
    }
    std::printf("%2d points: %d of 100 slips\n", n, found);
    EXPECT_GE(found, 80) << n;
  }
}

TEST(CalibrationFit, NoiseACurveAndExactPointsAreSeldomASlip) {
  for (const int n : {6, 21}) {
    int slips = 0;
    int of_curves = 0;
    for (unsigned seed = 0; seed < 1000; ++seed) {
      slips += FitCalibration(Slipped(seed, n, 0, 0), Scatter::kFromResiduals)->slip ? 1 : 0;
      auto curved = Slipped(seed, n, 0, 0);
      for (LinePoint& point : curved) point.x += 3e-4 * std::pow(point.x, 3);
      of_curves += FitCalibration(curved, Scatter::kFromResiduals)->slip ? 1 : 0;
    }
    std::printf("%2d points: %d of 1000 slips, of curves %d\n", n, slips, of_curves);
    // 1 % of 1000 and four standard deviations
    EXPECT_LE(slips, 22) << n;
    EXPECT_LE(of_curves, 30) << n;
  }
  std::vector<LinePoint> exact;
  for (int i = 0; i < 9; ++i) exact.push_back({0.1 * i, 0.3 * i, 1, 0});
  EXPECT_FALSE(FitCalibration(exact, Scatter::kFromResiduals)->slip);
}

TEST(CalibrationFit, HysteresisIsTheDifferenceOfUpAndDown) {
  // falling points read 10 mV more, so their displacements lie 10 um lower on the line
  const auto fit = FitCalibration(Points(2, 41, 0, 10e-6), Scatter::kFromResiduals);
  ASSERT_TRUE(fit && fit->hysteresis);
  EXPECT_TRUE(fit->hysteresis->is_significant);
  EXPECT_ABS(fit->hysteresis->difference, 10e-6, 4 * fit->hysteresis->standard_uncertainty,
             "four standard uncertainties");
  EXPECT_ABS(fit->hysteresis->standard_uncertainty, 1e-6 * std::sqrt(2. / 20), 1e-7,
             "noise of 20 points a side, 30 %");
}

TEST(CalibrationFit, DirectionsFollowTheOrderOfMeasurement) {
  std::vector<LinePoint> points;
  for (const double y : {0., 1., 2., 2., 1., 0.}) points.push_back({y, y, 1, 0});
  const auto fit = FitCalibration(points, Scatter::kFromResiduals);
  ASSERT_TRUE(fit);
  EXPECT_THAT(fit->directions, ElementsAre(0, 1, 1, 1, -1, -1));
  // without noise nothing is uncertain
  EXPECT_FALSE(fit->is_curved);
  EXPECT_ABS(fit->nonlinearity, 0, 1e-15, "round-off");
}

TEST(NormalizedError, IsTheDifferenceOverTheExpandedUncertainties) {
  // 1 % apart, U of 0.6 % and 0.8 %: E_n = 1
  EXPECT_REL(NormalizedError(1.01, 0.003, 1.0, 0.004).value(), 1.0, 1e-12, "round-off");
  EXPECT_EQ(NormalizedError(1, 0, 1, 0), 0);
  // exact numbers that differ, and uncertainties of rounding, explain nothing
  EXPECT_EQ(NormalizedError(1, 0, 2, 0), std::nullopt);
  EXPECT_EQ(NormalizedError(1, 1e-16, 2, 0), std::nullopt);
}

// Welch's two-sample variance of residuals, by the points' directions
double HysteresisUncertainty(const CalibrationFit& fit, double* difference) {
  double variance = 0;
  *difference = 0;
  for (const int direction : {-1, 1}) {
    std::vector<double> side;
    for (std::size_t i = 0; i < fit.directions.size(); ++i) {
      if (fit.directions[i] == direction) side.push_back(fit.line.residuals[i]);
    }
    const auto count = static_cast<double>(side.size());
    double mean = 0;
    for (const double residual : side) mean += residual / count;
    for (const double residual : side) {
      variance += std::pow(residual - mean, 2) / (count - 1) / count;
    }
    *difference += direction * mean;
  }
  return std::sqrt(variance);
}

TEST(CalibrationFit, HysteresisIsSignificantBeyondThreeStandardUncertainties) {
  // the gap at which it becomes significant, by halving; the noise's own is below 1 um
  double silent = 0;
  double significant = 5e-6;
  double ratio_silent = 0;
  double ratio_significant = 0;
  for (int halving = 0; halving < 14; ++halving) {
    const double gap = (silent + significant) / 2;
    const auto fit = FitCalibration(Points(4, 21, 0, gap), Scatter::kFromResiduals);
    ASSERT_TRUE(fit && fit->hysteresis);
    double difference = 0;
    const double uncertainty = HysteresisUncertainty(*fit, &difference);
    EXPECT_REL(fit->hysteresis->standard_uncertainty, uncertainty, 1e-9, "rounding");
    EXPECT_REL(fit->hysteresis->difference, difference, 1e-9, "rounding");
    const double ratio = std::abs(difference) / uncertainty;
    const bool is_significant = fit->hysteresis->is_significant;
    (is_significant ? significant : silent) = gap;
    (is_significant ? ratio_significant : ratio_silent) = ratio;
  }
  EXPECT_REL(ratio_silent, 3.0, 0.005, "halved 14 times");
  EXPECT_REL(ratio_significant, 3.0, 0.005, "halved 14 times");
  EXPECT_LE(ratio_silent, ratio_significant);
}

TEST(CalibrationFit, HysteresisNeedsTwoPointsOfEachDirection) {
  std::vector<LinePoint> points;
  for (const double y : {0., 1., 2., 1.}) points.push_back({y, y, 1, 0});
  EXPECT_FALSE(FitCalibration(points, Scatter::kFromResiduals)->hysteresis);
  points.push_back({0, 0, 1, 0});
  EXPECT_TRUE(FitCalibration(points, Scatter::kFromResiduals)->hysteresis);
}

// Eight equally spaced points of y = x with `quadratic` and 1 of the orthogonal polynomials of
// second and fourth degree, in units of 1e-5 (R. A. Fisher and F. Yates, Statistical Tables, XXIII)
std::vector<LinePoint> Orthogonal(double quadratic) {
  constexpr double kSecond[]{7, 1, -3, -5, -5, -3, 1, 7};
  constexpr double kFourth[]{7, -13, -3, 9, 9, -3, -13, 7};
  std::vector<LinePoint> points;
  for (int k = 0; k < 8; ++k) {
    points.push_back({1. * k, k + 1e-5 * (quadratic * kSecond[k] + kFourth[k]), 0, 1});
  }
  return points;
}

TEST(CalibrationFit, ACurveIsOneFromTheUpperPercentOfFishersFOn) {
  // F = (168 quadratic^2 / 2) / (616 / 4), whose upper tail with 2 and 4 degrees is (1 + F/2)^-2:
  // 1 % at F = 18
  const double limit = std::sqrt(18 * 2 * (616. / 4) / 168);
  const auto straight = FitCalibration(Orthogonal(0.995 * limit), Scatter::kFromResiduals);
  ASSERT_TRUE(straight);
  EXPECT_FALSE(straight->is_curved);
  EXPECT_EQ(straight->local_slope_uncertainty, 0);
  const auto curved = FitCalibration(Orthogonal(1.005 * limit), Scatter::kFromResiduals);
  ASSERT_TRUE(curved);
  EXPECT_TRUE(curved->is_curved);
  // the second polynomial is z^2 - 21/4 with z = k - 3.5: the RMS of its slope 2 z is 7/sqrt(3)
  EXPECT_REL(curved->local_slope_uncertainty, 1.005 * limit * 1e-5 * 7 / std::sqrt(3.0), 1e-9,
             "rounding of 1 in residuals of 1e-4");
}

// a curve of all three terms over the line; y = x with exact x
TEST(CalibrationFit, TheLocalSlopeIsTheRmsOfTheCurvesOverItsRange) {
  std::mt19937_64 engine(8);
  std::normal_distribution<double> noise(0, 1e-9);
  std::vector<LinePoint> points;
  const auto curve = [](double z) { return 0.02 * z * z + 0.015 * z * z * z; };
  for (int i = 0; i <= 20; ++i) {
    const double z = i / 10. - 1;
    // unevenly spaced, so that the line takes up part of the cubic
    const double place = z + 0.1 * z * z;
    points.push_back({3 * place, 6 * place + curve(place) + noise(engine), 0, 1e-9});
  }
  const auto fit = FitCalibration(points, Scatter::kFromResiduals);
  ASSERT_TRUE(fit);
  ASSERT_TRUE(fit->is_curved);
  // places from -0.9 to 1.1; the mean square of slopes by the middle rule over 10 000 of them
  double square = 0;
  for (int i = 0; i < 10'000; ++i) {
    const double place = -0.9 + 2 * (i + 0.5) / 10'000;
    const double slope = (6 + 0.04 * place + 0.045 * place * place) / 3;
    square += std::pow(slope / fit->line.slope - 1, 2) / 10'000;
  }
  EXPECT_REL(fit->local_slope_uncertainty, std::sqrt(square), 1e-5, "noise of 1e-9 over 1e-3");
  EXPECT_REL(
      fit->relative_uncertainty,
      std::hypot(fit->local_slope_uncertainty, fit->line.coverage_95 / 1.959963984540054 *
                                                   fit->line.slope_uncertainty / fit->line.slope),
      1e-12, "rounding");
}

TEST(NormalizedError, OfExactNumbersIsNone) {
  // uncertainties of 1e-12 of the larger number are rounding
  EXPECT_EQ(NormalizedError(1, 1.99e-12, 2, 0), std::nullopt);
  EXPECT_TRUE(NormalizedError(1, 2.01e-12, 2, 0));
  EXPECT_EQ(NormalizedError(-2, 1.99e-12, 1, 0), std::nullopt);
  // the sign is that of the difference
  EXPECT_REL(NormalizedError(1, 0.3, 2, 0.4).value(), -1.0, 1e-12, "1 / (2 * 0.5)");
}

}  // namespace
}  // namespace haptometer::fit
