#include "dsp/spectrum/kinematics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(Kinematics, TheResponseKeepsItsBound) {
  for (const double rate_hz : {1600.0, 2000.0, 4000.0, 10e3, 50e3, 392e3}) {
    const auto differentiator = DesignDifferentiator(rate_hz, 500);
    ASSERT_TRUE(differentiator) << rate_hz;
    EXPECT_LE(differentiator->relative_error, 1e-8);
    for (const double frequency_hz : {1.0, 20.0, 100.0, 225.0, 400.0, 500.0}) {
      const double theta = 2 * kPi * frequency_hz / rate_hz;
      double response = 0;
      for (std::size_t k = 1; k <= differentiator->taps.size(); ++k) {
        response += 2 * differentiator->taps[k - 1] * std::sin(static_cast<double>(k) * theta);
      }
      EXPECT_LE(response, theta * (1 + 4e-14)) << "it never raises";
      EXPECT_GE(response, theta * (1 - differentiator->relative_error - 4e-14))
          << rate_hz << ' ' << frequency_hz;
    }
  }
}

TEST(Kinematics, TheShortestOnesAreTheTextbooks) {
  // (x[1] - x[-1]) / 2, and (8, -1) / 12: bounds 2 sin^2 and 8/3 sin^4 of theta/2
  const auto one = DesignDifferentiator(1e6, 10);
  ASSERT_TRUE(one);
  ASSERT_EQ(one->taps.size(), 1U);
  EXPECT_EQ(one->taps[0], 0.5);
  const auto two = DesignDifferentiator(1e6, 1000);
  ASSERT_TRUE(two);
  ASSERT_EQ(two->taps.size(), 2U);
  EXPECT_REL(two->taps[0], 8.0 / 12, 1e-15, "rounding");
  EXPECT_REL(two->taps[1], -1.0 / 12, 1e-15, "rounding");
  EXPECT_REL(two->relative_error, 8.0 / 3 * std::pow(std::sin(kPi * 1e-3), 4), 1e-14, "rounding");
}

TEST(Kinematics, OfTonesIsTheClosedForm) {
  // 20 periods of 100 Hz, 45 of 225 Hz, 90 of 450 Hz in 0.2 s
  constexpr double kRateHz = 10e3;
  const std::vector<Sine> tones{{5e-6, 100, 0.1}, {2e-6, 225, 1}, {1e-6, 450, 2}};
  const std::vector<double> signal = Samples(kRateHz, 3000, 0, tones);
  const auto motion = DescribeKinematics(signal, kRateHz, 500, 400, 2400);
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->begin, 400U);
  EXPECT_EQ(motion->end, 2400U);
  double velocity = 0;
  double acceleration = 0;
  for (const Sine& tone : tones) {
    const double w = 2 * kPi * tone.frequency_hz;
    velocity += 0.5 * std::pow(tone.amplitude * w, 2);
    acceleration += 0.5 * std::pow(tone.amplitude * w * w, 2);
  }
  EXPECT_REL(motion->velocity_rms, std::sqrt(velocity), 1e-8, "the stated bound");
  EXPECT_REL(motion->acceleration_rms, std::sqrt(acceleration), 2e-8, "twice the stated bound");

  const std::vector<double> single = Samples(kRateHz, 3000, 0, {{5e-6, 100, 0}});
  const auto peak = DescribeKinematics(single, kRateHz, 500, 400, 2400);
  ASSERT_TRUE(peak);
  EXPECT_REL(peak->velocity_peak, 5e-6 * 200 * kPi, 1e-8, "a sample lies on the peak");
  EXPECT_REL(peak->acceleration_peak, 5e-6 * 4e4 * kPi * kPi, 2e-8, "the same");
}

TEST(Kinematics, TheWindowShrinksAtTheEndsAndMayVanish) {
  const std::vector<double> signal = Samples(10e3, 1000, 0, {{1, 100, 0}});
  const auto motion = DescribeKinematics(signal, 10e3, 500, 0, 1000);
  ASSERT_TRUE(motion);
  const std::size_t reach = 2 * DesignDifferentiator(10e3, 500)->taps.size();
  EXPECT_EQ(motion->begin, reach);
  EXPECT_EQ(motion->end, 1000 - reach);
  EXPECT_FALSE(DescribeKinematics(signal, 10e3, 500, 0, reach));
  EXPECT_FALSE(DescribeKinematics(signal, 10e3, 500, 500, 500));
  EXPECT_FALSE(DescribeKinematics(signal, 1000, 400, 0, 1000)) << "0.4 of the rate";
  EXPECT_FALSE(DescribeKinematics({}, 10e3, 500, 0, 0));
}

// 4^64 / binomial(128, 64) sin(theta/2)^128 = 1e-8, by logarithms of factorials
TEST(Kinematics, SixtyFourTapsReachTheStatedBound) {
  const double ratio = 64 * std::log(4.0) - (std::lgamma(129.0) - 2 * std::lgamma(65.0));
  const double sine = std::exp((std::log(1e-8) - ratio) / 128);
  const double upper = 2 * std::asin(sine) / (2 * kPi);
  EXPECT_ABS(upper, 0.32, 0.005, "the stated share of the rate");
  EXPECT_EQ(DesignDifferentiator(1, 0.9999 * upper)->taps.size(), 64U);
  EXPECT_FALSE(DesignDifferentiator(1, 1.0001 * upper));
  EXPECT_FALSE(DesignDifferentiator(1, 0.5));
}

// one sample that has all its neighbours, and none
TEST(Kinematics, NeedsASampleWithAllItsNeighbours) {
  const std::size_t reach = 2 * DesignDifferentiator(10e3, 500)->taps.size();
  const std::vector<double> signal = Samples(10e3, 2 * reach + 1, 0, {{1, 100, 0}});
  const auto motion = DescribeKinematics(signal, 10e3, 500, 0, signal.size());
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->begin, reach);
  EXPECT_EQ(motion->end, reach + 1);
  const double w = 2 * kPi * 100;
  const double phase = w * static_cast<double>(reach) / 10e3;
  EXPECT_REL(motion->velocity_peak, w * std::abs(std::cos(phase)), 1e-7, "the stated bound");
  EXPECT_REL(motion->velocity_rms, motion->velocity_peak, 1e-15, "of one sample");
  EXPECT_REL(motion->acceleration_peak, w * w * std::abs(std::sin(phase)), 1e-7, "the same");
  EXPECT_REL(motion->acceleration_rms, motion->acceleration_peak, 1e-15, "of one sample");
  EXPECT_FALSE(DescribeKinematics(std::span(signal).first(2 * reach), 10e3, 500, 0, 2 * reach));
}

TEST(KinematicsDeathTest, RatesAndWindowsAreChecked) {
  const std::vector<double> signal(1000, 1.0);
  EXPECT_DEATH(static_cast<void>(DesignDifferentiator(0, 500)), "check failed");
  EXPECT_DEATH(static_cast<void>(DesignDifferentiator(10e3, 0)), "check failed");
  EXPECT_DEATH(static_cast<void>(DescribeKinematics(signal, 10e3, 500, 0, 1001)), "check failed");
  EXPECT_DEATH(static_cast<void>(DescribeKinematics(signal, 10e3, 500, 501, 500)), "check failed");
}

}  // namespace
}  // namespace haptometer::dsp
