// The oracle is the closed form of |H|, and sines whose amplitude is known.
#include "dsp/spectrum/decimated.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "dsp/statistics/moments.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 10e3;

TEST(Decimator, PassesASineWithItsGainAndNoPhase) {
  const std::vector<double> signal = Samples(kRateHz, 40'000, 0.03, {{1e-3, 8.3, 0.4}});
  const Decimator decimator(16, kRateHz);
  EXPECT_EQ(decimator.taps(), 91U);
  const std::vector<double> slow = decimator.Decimate(signal);
  ASSERT_EQ(slow.size(), decimator.SizeOf(signal.size()));
  for (std::size_t k = 0; k < slow.size(); ++k) {
    const std::size_t center = 16 * k + 45;
    const double expected = 0.03 + decimator.GainAt(8.3) * (signal[center] - 0.03);
    EXPECT_NEAR(slow[k], expected, 5e-17) << "rounding of 91 products of 0.03";
  }
}

TEST(Decimator, GainIsTheClosedForm) {
  const Decimator decimator(8, kRateHz);
  EXPECT_EQ(decimator.GainAt(0), 1);
  // zeros at multiples of the new rate; sinc^6 for frequencies far below both rates
  EXPECT_ABS(decimator.GainAt(1250), 0, 1e-90, "sin(pi) is 1.2e-16, to the sixth");
  const double x = std::numbers::pi * 5 / 1250;
  EXPECT_REL(decimator.GainAt(5), 1 - x * x * (1 - 1.0 / 64), 2e-8, "x^4 is 2.5e-8 of it");
}

TEST(Decimator, WhatFoldsIsBelowItsBound) {
  const Decimator decimator(16, kRateHz);
  const double folded_hz = decimator.rate_hz() - decimator.rate_hz() / 16;
  const std::vector<double> slow =
      decimator.Decimate(Samples(kRateHz, 40'000, 0, {{1, folded_hz, 0.2}}));
  EXPECT_LT(Rms(slow) * std::numbers::sqrt2, 1e-7);
  EXPECT_GT(Rms(slow) * std::numbers::sqrt2, 5e-8) << "the bound is near";
}

TEST(Decimator, FactorLeavesRateAndLength) {
  EXPECT_EQ(Decimator::FactorFor(10'000, 392e3, 320, 10'000), 1U) << "short";
  EXPECT_EQ(Decimator::FactorFor(1U << 21U, 10e3, 320, 1000), 16U) << "625 Hz, 312.5 are too few";
  EXPECT_EQ(Decimator::FactorFor(1U << 21U, 392e3, 320, 1U << 14U), 128U) << "2^14 samples";
  EXPECT_EQ(Decimator::FactorFor(1U << 19U, 10e3, 8000, 1), 1U);
}

TEST(Decimator, ByOneIsNothing) {
  const std::vector<double> signal = Samples(kRateHz, 100, 0.03, {{1e-3, 8.3, 0.4}});
  EXPECT_EQ(Decimator(1, kRateHz).Decimate(signal), signal);
  EXPECT_TRUE(Decimator(64, kRateHz).Decimate(signal).empty()) << "fewer than its taps";
}

// 2 samples, 6 times over: 7 taps
TEST(Decimator, TakesWhatItsTapsReach) {
  const Decimator decimator(2, kRateHz);
  ASSERT_EQ(decimator.taps(), 7U);
  EXPECT_EQ(decimator.rate_hz(), kRateHz / 2);
  EXPECT_EQ(decimator.SizeOf(6), 0U);
  EXPECT_EQ(decimator.SizeOf(7), 1U);
  EXPECT_EQ(decimator.SizeOf(8), 1U);
  EXPECT_EQ(decimator.SizeOf(9), 2U);
  // (1 + z)^6 / 64
  const std::vector<double> binomial{1, 6, 15, 20, 15, 6, 1};
  for (std::size_t k = 0; k < binomial.size(); ++k) {
    std::vector<double> impulse(7);
    impulse[k] = 64;
    EXPECT_EQ(decimator.Decimate(impulse), std::vector<double>{binomial[k]});
  }
}

TEST(Decimator, FactorIsThatOfTheLimitsThemselves) {
  EXPECT_EQ(Decimator::FactorFor(8192, 10e3, 5000, 4096), 2U) << "both limits are met";
  EXPECT_EQ(Decimator::FactorFor(8191, 10e3, 5000, 4096), 1U);
  EXPECT_EQ(Decimator::FactorFor(8192, 10e3, 5001, 4096), 1U);
}

TEST(DecimatorDeathTest, HasAFactorAndARate) {
  EXPECT_DEATH(Decimator(0, kRateHz), "check failed");
  EXPECT_DEATH(Decimator(2, 0), "check failed");
}

}  // namespace
}  // namespace haptometer::dsp
