#include "dsp/spectrum/harmonics.h"

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
constexpr double kRateHz = 10e3;

TEST(Harmonics, AreFoundTogetherAtAnyLength) {
  // 3.7 periods and a slope: an FFT's bins would smear all of it
  std::vector<double> signal =
      Samples(kRateHz, 168, 0.03, {{5e-6, 220, 0.3}, {1e-6, 440, -1}, {2e-7, 880, 2}});
  for (std::size_t k = 0; k < signal.size(); ++k) signal[k] += 1e-7 * static_cast<double>(k);
  const Harmonics found = FitHarmonics(signal, {kRateHz, 0, 1}, 220, 1100);
  ASSERT_TRUE(found.converged);
  ASSERT_EQ(found.harmonics.size(), 5U);
  constexpr const char* kReason = "the input's rounding at 30 mm, 3.5e-18 m";
  EXPECT_ABS(found.harmonics[0].amplitude, 5e-6, 1e-17, kReason);
  EXPECT_ABS(found.harmonics[1].amplitude, 1e-6, 1e-17, kReason);
  EXPECT_ABS(found.harmonics[2].amplitude, 0, 1e-17, kReason);
  EXPECT_ABS(found.harmonics[3].amplitude, 2e-7, 1e-17, kReason);
  EXPECT_ABS(found.harmonics[4].amplitude, 0, 1e-17, kReason);
  EXPECT_ABS(found.harmonics[1].phase_rad, -1 - kPi / 2, 1e-11, "the same over 1e-6");
  EXPECT_ABS(found.harmonics[3].phase_rad, 2 - kPi / 2, 5e-11, "the same over 2e-7");
  EXPECT_REL(found.thd.value(), std::hypot(1, 0.2) / 5, 1e-11, "the same");
  EXPECT_EQ(found.harmonics[3].frequency_hz, 880);
}

TEST(Harmonics, TheLimitAndHalfTheRateCut) {
  const std::vector<double> signal = Samples(kRateHz, 1000, 0, {{1, 1250, 0}});
  EXPECT_EQ(FitHarmonics(signal, {kRateHz, 0}, 1250, 2500).harmonics.size(), 2U) << "on the limit";
  EXPECT_EQ(FitHarmonics(signal, {kRateHz, 0}, 1250, 2499).harmonics.size(), 1U);
  EXPECT_EQ(FitHarmonics(signal, {kRateHz, 0}, 1250, 9999).harmonics.size(), 3U)
      << "the fourth is half the rate";
  EXPECT_FALSE(FitHarmonics(signal, {kRateHz, 0}, 1250, 2499).thd) << "none to sum";
  EXPECT_FALSE(FitHarmonics(signal, {kRateHz, 0}, 5, 500).converged) << "half a period";
  EXPECT_FALSE(FitHarmonics(std::span(signal).first(8), {kRateHz, 0, 1}, 1250, 5000).converged)
      << "eight samples, eight parameters, no residual left to judge by";
}

Harmonics Noisy(Noise& noise, double second, double third) {
  std::vector<double> signal =
      Samples(kRateHz, 400, 0, {{1, 203, 0.3}, {second, 406, -1}, {third, 609, 2}});
  for (double& x : signal) x += 0.1 * noise();
  return FitHarmonics(signal, {kRateHz, 0}, 203, 1100);
}

constexpr int kRepetitions = 2000;

TEST(Harmonics, IntervalsHoldTheTruth) {
  Noise noise(5);
  constexpr double kT389 = 1.966;  // Student's t, 97.5 %, 400 - 11 degrees of freedom
  const double thd = std::hypot(0.08, 0.06);
  int second = 0;
  int phase = 0;
  int distortion = 0;
  int bounded = 0;
  for (int r = 0; r < kRepetitions; ++r) {
    const Harmonics found = Noisy(noise, 0.08, 0.06);
    const Harmonic& h = found.harmonics[1];
    second += std::abs(h.amplitude - 0.08) <= kT389 * h.amplitude_uncertainty ? 1 : 0;
    const double turned = std::remainder(h.phase_rad - (-1 - kPi / 2), 2 * kPi);
    phase += std::abs(turned) <= kT389 * h.phase_uncertainty_rad ? 1 : 0;
    ASSERT_TRUE(found.thd);
    distortion += std::abs(*found.thd - thd) <= kT389 * found.thd_uncertainty ? 1 : 0;
    bounded += thd <= *found.thd_at_most ? 1 : 0;
  }
  // 95 % +- 2 %: four deviations of the count
  EXPECT_NEAR(second, 1900, 40);
  EXPECT_NEAR(phase, 1900, 40);
  EXPECT_NEAR(distortion, 1900, 40);
  EXPECT_NEAR(bounded, 1900, 40);
}

TEST(Harmonics, NoiseIsNoDistortion) {
  Noise noise(6);
  int determined = 0;
  int stands_out = 0;
  int bounded = 0;
  for (int r = 0; r < kRepetitions; ++r) {
    const Harmonics found = Noisy(noise, 0, 0);
    determined += found.thd ? 1 : 0;
    stands_out += found.harmonics[2].stands_out ? 1 : 0;
    bounded += found.thd_at_most ? 1 : 0;
  }
  EXPECT_NEAR(determined, 20, 18) << "1 % of 2000, four deviations";
  EXPECT_NEAR(stands_out, 20, 18) << "the same";
  EXPECT_EQ(bounded, kRepetitions);
}

TEST(Harmonics, NoisePowerIsTakenOff) {
  // without it, four multiples of noise alone add 8 u^2 to the squared THD
  Noise noise(7);
  double mean_square = 0;
  double with_noise = 0;  // what the amplitudes as they were found add up to
  for (int r = 0; r < kRepetitions; ++r) {
    const Harmonics found = Noisy(noise, 0.05, 0.03);
    ASSERT_TRUE(found.thd) << r;
    mean_square += *found.thd * *found.thd / kRepetitions;
    double sum = 0;
    for (const Harmonic& h : std::span(found.harmonics).subspan(1))
      sum += h.amplitude * h.amplitude;
    const double first = found.harmonics[0].amplitude;
    with_noise += sum / (first * first) / kRepetitions;
  }
  EXPECT_REL(mean_square, 0.0034, 0.02, "deviation of one: 2 u thd = 8e-4; of the mean 2e-5");
  EXPECT_REL(with_noise, 0.0034 + 8 * (2 * 0.01 / 400), 0.02, "the same; 8 u^2 not taken off");
}

}  // namespace
}  // namespace haptometer::dsp
