#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "fit/skin/skin_fit.h"
#include "tests/fit/skin/synthetic_sweep.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using tests::Actuator;
using tests::Bounds;
using tests::Measure;
using tests::Spaced;
using Sweep = tests::SyntheticSweep;

SkinFit Fit(const SkinSweep& sweep, const sim::StatedActuator& actuator = Actuator()) {
  const auto fit = FitSkin(sweep, actuator);
  EXPECT_TRUE(fit) << fit.error().Text();
  return fit ? *fit : SkinFit{};
}

TEST(SkinFit, APointThatLacksANumberIsLeftOut) {
  const auto good = Measure(
      {.frequencies_hz = Spaced(40, 500, 12), .magnitude_noise = 0.01, .phase_noise_rad = 0.01});
  auto whole = good;
  for (auto& point : whole.points) {
    point.displacement_standard_uncertainty_m = 0.01 * point.displacement_m;
  }
  ASSERT_EQ(Fit(whole).points, 12U);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const std::function<void(SkinPoint&, double)> numbers[]{
      [](SkinPoint& point, double value) { point.frequency_hz = value; },
      [](SkinPoint& point, double value) { point.displacement_m = value; },
      [](SkinPoint& point, double value) { point.drive = value; },
      [](SkinPoint& point, double value) { point.phase_rad = value; },
      [](SkinPoint& point, double value) { point.displacement_standard_uncertainty_m = value; }};
  for (const auto& set : numbers) {
    for (const double value : {kNan, kInfinite}) {
      auto hole = whole;
      set(hole.points[4], value);
      EXPECT_EQ(Fit(hole).points, 11U) << &set - numbers;
    }
  }
}

TEST(SkinFit, NumbersThatAreNotPositiveAreRefusedWithTheirPoint) {
  const auto good = Measure({.frequencies_hz = Spaced(40, 500, 12)});
  const auto error = [](const SkinSweep& sweep) {
    const auto fit = FitSkin(sweep, Actuator());
    return fit ? "" : fit.error().Text();
  };
  EXPECT_EQ(error(good), "");
  for (const double value : {0.0, -1e-6}) {
    auto frequency = good;
    frequency.points[4].frequency_hz = value;
    EXPECT_THAT(error(frequency), ::testing::HasSubstr("frequencies, amplitudes and drives are"));
    auto amplitude = good;
    amplitude.points[4].displacement_m = value;
    EXPECT_THAT(error(amplitude), ::testing::HasSubstr("frequencies, amplitudes and drives are"));
    auto drive = good;
    drive.points[4].drive = value;
    EXPECT_THAT(error(drive), ::testing::HasSubstr("frequencies, amplitudes and drives are"));
    auto uncertain = good;
    for (auto& point : uncertain.points) point.displacement_standard_uncertainty_m = 1e-8;
    EXPECT_EQ(error(uncertain), "");
    uncertain.points[4].displacement_standard_uncertainty_m = value;
    EXPECT_THAT(error(uncertain), ::testing::HasSubstr("an uncertainty that is not positive"));
  }
  auto some = good;
  some.points[4].displacement_standard_uncertainty_m = 1e-8;
  EXPECT_THAT(error(some), ::testing::HasSubstr("for some points only"));
  some = good;
  some.points[4].phase_rad = 0.1;
  EXPECT_THAT(error(some), ::testing::HasSubstr("for some points only"));
}

TEST(SkinFit, StatedUncertaintiesAboveTheScatterAreTheBounds) {
  Sweep sweep{.frequencies_hz = Spaced(40, 500, 20), .magnitude_noise = 0.01};
  auto measured = Measure(sweep);
  for (auto& point : measured.points) {
    point.displacement_standard_uncertainty_m = 0.04 * point.displacement_m;
  }
  const auto fit = Fit(measured);
  EXPECT_EQ(fit.magnitude_noise, 1) << "what is stated, not the scatter of a quarter of it";
  sweep.truth = {fit.stiffness.value, fit.damping.value, fit.mass.value};
  sweep.magnitude_noise = 0.04;
  const auto bounds = Bounds(sweep);
  EXPECT_REL(fit.stiffness.standard_uncertainty / fit.stiffness.value, bounds[0], 1e-5,
             "differences of the bound");
  EXPECT_REL(fit.damping.standard_uncertainty / fit.damping.value, bounds[1], 1e-5,
             "differences of the bound");
  EXPECT_REL(fit.mass.standard_uncertainty, bounds[2], 1e-5, "differences of the bound");
}

// ln |x/v| and arg(x/v) at each frequency, in units of the fit's noises
Eigen::VectorXd WeightedMotion(const SkinSweep& sweep, const SkinFit& fit,
                               const sim::Actuator& actuator,
                               const std::vector<double>& parameters) {
  const auto count = static_cast<Eigen::Index>(sweep.points.size());
  Eigen::VectorXd values(2 * count);
  for (Eigen::Index n = 0; n < count; ++n) {
    const auto& point = sweep.points[static_cast<std::size_t>(n)];
    const auto motion = ContactAt(actuator, sweep.drive, parameters, point.frequency_hz).motion;
    values[n] = std::log(std::abs(motion)) / fit.magnitude_noise;
    values[n + count] =
        std::arg(motion * std::polar(1.0, -*point.phase_rad)) / fit.phase_noise_rad.value_or(1);
  }
  return values;
}

TEST(SkinFit, InfluencesUnderAVoltageAreThoseOfTheLinearLeastSquares) {
  const auto sweep = Measure({.frequencies_hz = Spaced(40, 500, 20),
                              .magnitude_noise = 1e-2,
                              .phase_noise_rad = 2e-2,
                              .drive = DriveQuantity::kVoltage});
  const auto fit = Fit(sweep);
  ASSERT_EQ(fit.influences.size(), 8U);
  const std::vector<double> at{std::log(fit.stiffness.value), std::log(fit.damping.value),
                               fit.mass.value};
  const double steps[]{1e-5, 1e-5, 1e-8};
  Eigen::MatrixXd slopes(40, 3);
  for (std::size_t k = 0; k < 3; ++k) {
    auto up = at;
    auto down = at;
    up[k] += steps[k];
    down[k] -= steps[k];
    slopes.col(static_cast<Eigen::Index>(k)) =
        (WeightedMotion(sweep, fit, sim::ThesisC10100(), up) -
         WeightedMotion(sweep, fit, sim::ThesisC10100(), down)) /
        (2 * steps[k]);
  }
  for (std::size_t k = 0; k < 7; ++k) {
    constexpr double kShare = 1e-5;
    auto more = sim::ThesisC10100();
    auto less = sim::ThesisC10100();
    more.*sim::kActuatorNumbers[k] *= 1 + kShare;
    less.*sim::kActuatorNumbers[k] *= 1 - kShare;
    const Eigen::VectorXd change =
        (WeightedMotion(sweep, fit, more, at) - WeightedMotion(sweep, fit, less, at)) /
        (2 * kShare);
    const Eigen::Vector3d response = -slopes.colPivHouseholderQr().solve(change);
    const SkinInfluence& influence = fit.influences[k];
    EXPECT_EQ(influence.input, sim::kActuatorSymbols[k]);
    constexpr const char* kReason = "differences of 1e-4 there, of 1e-5 here";
    EXPECT_ABS(influence.stiffness_percent_per_percent, response[0], 1e-5, kReason)
        << influence.input;
    EXPECT_ABS(influence.damping_percent_per_percent, response[1], 1e-5, kReason)
        << influence.input;
    EXPECT_ABS(influence.mass_kg_per_percent, response[2] / 100, 1e-10, kReason) << influence.input;
  }
}

TEST(SkinFit, ADisplacementThatIsTooLargeIsAForceConstantThatIsTooSmall) {
  auto actuator = Actuator();
  actuator.force_constant_n_per_a = Quantity{1.0, 0.02};
  for (const bool states_uncertainty : {false, true}) {
    const auto fit = Fit(Measure({.frequencies_hz = Spaced(40, 500, 20),
                                  .magnitude_noise = 1e-3,
                                  .states_uncertainty = states_uncertainty}),
                         actuator);
    const SkinInfluence& constant = fit.influences.at(4);
    const SkinInfluence& scale = fit.influences.at(7);
    EXPECT_REL(constant.relative_standard_uncertainty, 0.02, 1e-12, "as stated");
    EXPECT_EQ(scale.relative_standard_uncertainty, 0);
    EXPECT_REL(scale.stiffness_percent_per_percent, -constant.stiffness_percent_per_percent, 1e-6,
               "by current the response is Km times a shape");
    EXPECT_REL(scale.damping_percent_per_percent, -constant.damping_percent_per_percent, 1e-6,
               "by current the response is Km times a shape");
    EXPECT_REL(scale.mass_kg_per_percent, -constant.mass_kg_per_percent, 1e-6,
               "by current the response is Km times a shape");
  }
}

TEST(SkinFit, TheModelsAmplitudesAreThoseOfTheSweep) {
  for (const auto drive : {DriveQuantity::kCurrent, DriveQuantity::kVoltage}) {
    auto sweep = Measure({.frequencies_hz = Spaced(50, 500, 15), .drive = drive});
    // drives that differ, and a table in another order
    for (std::size_t k = 0; k < sweep.points.size(); ++k) {
      const double factor = 1 + 0.1 * static_cast<double>(k % 4);
      sweep.points[k].drive *= factor;
      sweep.points[k].displacement_m *= factor;
    }
    const auto ordered = sweep.points;
    std::ranges::reverse(sweep.points);
    const auto fit = Fit(sweep);
    ASSERT_EQ(fit.model_m.size(), ordered.size());
    for (std::size_t k = 0; k < ordered.size(); ++k) {
      EXPECT_EQ(fit.frequencies_hz[k], ordered[k].frequency_hz);
      EXPECT_EQ(fit.measured_m[k], ordered[k].displacement_m);
      EXPECT_REL(fit.model_m[k], ordered[k].displacement_m, 1e-12, "noise-free");
    }
  }
}

}  // namespace
}  // namespace haptometer::fit
