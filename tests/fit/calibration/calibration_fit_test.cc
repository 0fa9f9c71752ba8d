#include "fit/calibration/calibration_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using ::testing::ElementsAre;

// n points over +-5 V of 1 mm/V, up and then down, with noise of 1 mV; `bend` and `gap` in m
std::vector<LinePoint> Points(unsigned seed, int n, double bend = 0, double gap = 0) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> noise(0, 1e-3);
  std::vector<LinePoint> points;
  for (int i = 0; i < n; ++i) {
    const int half = (n + 1) / 2;
    const bool is_rising = i < half;
    const double z = -1 + 2. * (is_rising ? i : n - 1 - i) / (half - 1);
    const double volts = 5 * z - 1e3 * bend * (z * z * z - 0.6 * z) + (is_rising ? 0 : 1e3 * gap);
    points.push_back({volts + noise(engine), 5e-3 * z, 1e-3, 0});
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
  EXPECT_REL(NormalizedError(1.01, 0.003, 1.0, 0.004), 1.0, 1e-12, "round-off");
  EXPECT_EQ(NormalizedError(1, 0, 1, 0), 0);
  EXPECT_TRUE(std::isinf(NormalizedError(1, 0, 2, 0)));
}

}  // namespace
}  // namespace haptometer::fit
