#include "dsp/spectrum/slow_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <utility>
#include <vector>

#include "dsp/statistics/distributions.h"
#include "tests/dsp/repetitions.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 200;

TEST(SlowMotion, DriftAndASteadyTremor) {
  std::vector<double> signal = Samples(kRateHz, 1600, 0.03, {{0.5e-3, 8.3, 0.4}});
  for (std::size_t k = 0; k < signal.size(); ++k) {
    signal[k] += 2e-4 * static_cast<double>(k) / kRateHz;
  }
  const auto motion = DescribeSlowMotion(signal, kRateHz);
  ASSERT_TRUE(motion && motion->tremor_rms);
  EXPECT_ABS(motion->drift_per_s, 2e-4, 4 * motion->drift_uncertainty_per_s, "as stated");
  EXPECT_LT(motion->drift_uncertainty_per_s, 5e-6) << "a tremor of 8.3 periods an eighth";
  EXPECT_REL(*motion->tremor_rms, 0.5e-3 / std::numbers::sqrt2, 2e-8, "what is left of the line");
  EXPECT_REL(motion->tremor_frequency_hz, 8.3, 1e-8, "the power's centre");
}

TEST(SlowMotion, ABroadTremorIsABand) {
  // white noise of density 2 s^2/rate; 10 Hz of it
  Noise noise(12);
  std::vector<double> signal(12'000);
  for (double& x : signal) x = 1e-4 * noise();
  const auto motion = DescribeSlowMotion(signal, kRateHz);
  ASSERT_TRUE(motion && motion->tremor_rms);
  EXPECT_REL(*motion->tremor_rms, 1e-4 * std::sqrt(2 * 10 / kRateHz), 0.12,
             "3.5 deviations: 1/sqrt(4 x 10 Hz x 60 s)");
  EXPECT_REL(motion->tremor_rms_uncertainty / *motion->tremor_rms, 1 / std::sqrt(4 * 10 * 60), 0.1,
             "the spectrum's own scatter, 2 / 30 of its width");
  EXPECT_ABS(motion->tremor_frequency_hz, 8, 0.5, "the middle");
}

TEST(SlowMotion, TheDriftsIntervalHoldsTheTruth) {
  // noise whose correlation lasts a twentieth of an eighth: pole 0.9, 200 samples an eighth
  constexpr int kRepetitions = 2000;
  constexpr double kT6 = 2.4469119;  // Student's t, 97.5 %, 6 degrees of freedom
  Noise noise(19);
  int held = 0;
  std::vector<double> signal(800);
  for (int r = 0; r < kRepetitions; ++r) {
    double state = 2.3 * noise();
    for (std::size_t k = 0; k < signal.size(); ++k) {
      state = 0.9 * state + noise();
      signal[k] = state + 3 * static_cast<double>(k) / kRateHz;
    }
    const auto motion = DescribeSlowMotion(std::span(signal).first(800), 40);
    ASSERT_TRUE(motion);
    held += std::abs(motion->drift_per_s - 0.6) <= kT6 * motion->drift_uncertainty_per_s ? 1 : 0;
  }
  EXPECT_NEAR(held, 1900, 40) << "95 % +- 2 % of 2000";
}

// the 95 % interval that its standard uncertainty states
bool HoldsTremor(const SlowMotion& motion, double truth) {
  const double ratio = *motion.tremor_rms / motion.tremor_rms_uncertainty;
  return std::abs(*motion.tremor_rms - truth) <=
         StudentCritical(0.5 * ratio * ratio) * motion.tremor_rms_uncertainty;
}

// white noise: 10 Hz of its density 2 s^2/rate lie in the tremor's band
TEST(SlowMotion, ABroadTremorsIntervalHoldsTheTruth) {
  const double truth = std::sqrt(2 * 10 / kRateHz);
  const int repetitions = Repetitions(200);
  Noise noise(29);
  int held = 0;
  std::vector<double> signal(1600);
  for (int r = 0; r < repetitions; ++r) {
    for (double& x : signal) x = noise();
    const auto motion = DescribeSlowMotion(signal, kRateHz);
    ASSERT_TRUE(motion && motion->tremor_rms);
    held += HoldsTremor(*motion, truth) ? 1 : 0;
  }
  ExpectCoverage("RMS of a broad tremor", held, repetitions);
}

// noise of RMS 1 through a resonance at 8 Hz, some 1 Hz wide
TEST(SlowMotion, ANarrowTremorsIntervalHoldsTheTruth) {
  const double radius = std::exp(-std::numbers::pi * 1 / kRateHz);
  const double a1 = 2 * radius * std::cos(2 * std::numbers::pi * 8 / kRateHz);
  const double a2 = -radius * radius;
  double square = 0;  // by the density, within the band
  constexpr int kSteps = 20'000;
  for (int k = 0; k < kSteps; ++k) {
    const double f = kTremorLower_hz + (kTremorUpper_hz - kTremorLower_hz) * (k + 0.5) / kSteps;
    const std::complex<double> z = std::polar(1.0, -2 * std::numbers::pi * f / kRateHz);
    square += 2 / kRateHz / std::norm(1.0 - a1 * z - a2 * z * z) *
              (kTremorUpper_hz - kTremorLower_hz) / kSteps;
  }
  const int repetitions = Repetitions(200);
  Noise noise(31);
  int held = 0;
  std::vector<double> signal(4000);
  double x1 = 0;
  double x2 = 0;
  for (int r = -1; r < repetitions; ++r) {
    for (double& x : signal) {
      x = a1 * x1 + a2 * x2 + noise();
      x2 = std::exchange(x1, x);
    }
    if (r < 0) continue;  // it begins at rest
    const auto motion = DescribeSlowMotion(signal, kRateHz);
    ASSERT_TRUE(motion && motion->tremor_rms);
    held += HoldsTremor(*motion, std::sqrt(square)) ? 1 : 0;
  }
  ExpectCoverage("RMS of a narrow tremor", held, repetitions);
}

TEST(SlowMotion, IsNotMadeUp) {
  std::vector<double> signal(15, 1.0);
  EXPECT_FALSE(DescribeSlowMotion(signal, kRateHz));
  signal.resize(150, 1.0);
  const auto brief = DescribeSlowMotion(signal, kRateHz);
  ASSERT_TRUE(brief);
  EXPECT_FALSE(brief->tremor_rms) << "0.75 s";
  EXPECT_FALSE(DescribeSlowMotion(std::vector<double>(150, 1.0), 50)->tremor_rms) << "50 Hz";
  signal[3] = std::nan("");
  EXPECT_FALSE(DescribeSlowMotion(signal, kRateHz));
  const auto still = DescribeSlowMotion(std::vector<double>(800, 0.03), kRateHz);
  ASSERT_TRUE(still && still->tremor_rms);
  EXPECT_EQ(*still->tremor_rms, 0);
  EXPECT_EQ(still->drift_per_s, 0);
}

// eight parts of 20 values and 7 values more; each part's level is off the line by 1 or -1 in an
// order that shares nothing with a line: s^2 = 8 / 6, over 42 in squares of the parts' numbers
TEST(SlowMotion, TheDriftAndItsUncertaintyAreThoseOfEightMeans) {
  constexpr double kOff[] = {1, -1, -1, 1, 1, -1, -1, 1};
  std::vector<double> signal(167, 1e3);
  for (std::size_t k = 0; k < 160; ++k) {
    signal[k] = kOff[k / 20] + 0.05 * static_cast<double>(k);
  }
  const auto motion = DescribeSlowMotion(signal, 40);
  ASSERT_TRUE(motion);
  EXPECT_REL(motion->drift_per_s, 0.05 * 40, 1e-13, "rounding");
  EXPECT_REL(motion->drift_uncertainty_per_s, std::sqrt(8.0 / 6 / 42) / 20 * 40, 1e-12, "rounding");
}

TEST(SlowMotion, NeedsSixteenSamplesASecondAndFourTimesTheTremorsRate) {
  EXPECT_TRUE(DescribeSlowMotion(std::vector<double>(16, 1.0), kRateHz));
  EXPECT_FALSE(DescribeSlowMotion(std::vector<double>(199, 1.0), kRateHz)->tremor_rms) << "0.995 s";
  EXPECT_TRUE(DescribeSlowMotion(std::vector<double>(200, 1.0), kRateHz)->tremor_rms) << "1 s";
  EXPECT_FALSE(DescribeSlowMotion(std::vector<double>(200, 1.0), 51.9)->tremor_rms);
  EXPECT_TRUE(DescribeSlowMotion(std::vector<double>(200, 1.0), 52)->tremor_rms);
}

TEST(SlowMotion, ARecordAtRestHasATremorOfNothing) {
  const auto still = DescribeSlowMotion(std::vector<double>(800, 0.03), kRateHz);
  ASSERT_TRUE(still && still->tremor_rms);
  EXPECT_EQ(still->tremor_frequency_hz, 0);
  EXPECT_EQ(still->tremor_rms_uncertainty, 0);
  EXPECT_EQ(still->drift_uncertainty_per_s, 0);
}

// Hann's window spreads a tone on a bin over three of 1/6, 2/3 and 1/6 of its power: their width is
// 2 bins of 0.25 Hz
TEST(SlowMotion, TheUncertaintyOfASteadyTremorIsThatOfTheWindowsWidth) {
  const std::vector<double> signal = Samples(kRateHz, 8000, 0, {{1e-3, 8, 0.4}});
  const auto motion = DescribeSlowMotion(signal, kRateHz);
  ASSERT_TRUE(motion && motion->tremor_rms);
  EXPECT_REL(motion->tremor_rms_uncertainty / *motion->tremor_rms, 1 / std::sqrt(4 * 2 * 0.25 * 40),
             1e-4, "what the line takes of the tone");
}

TEST(SlowMotionDeathTest, HasARate) {
  const std::vector<double> signal(200, 1.0);
  EXPECT_DEATH(static_cast<void>(DescribeSlowMotion(signal, 0)), "check failed");
}

// A tone on a bin shares a quarter of its density with either neighbour: at the ends of 3 to 13 Hz
// that bin and one neighbour count.
TEST(SlowMotion, TheTremorsCentreCountsTheBinsAtBothEnds) {
  for (const double tone_hz : {3.0, 13.0}) {
    const std::vector<double> tone = Samples(kRateHz, 4000, 0, {{1e-3, tone_hz, 0.4}});
    const auto motion = DescribeSlowMotion(tone, kRateHz);
    ASSERT_TRUE(motion);
    EXPECT_REL(motion->tremor_frequency_hz, tone_hz + (tone_hz < 8 ? 0.05 : -0.05), 1e-3,
               "the line that is taken off");
  }
}

}  // namespace
}  // namespace haptometer::dsp
