#include "dsp/spectrum/sine_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "dsp/spectrum/tone.h"
#include "dsp/statistics/moments.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRateHz = 10e3;

TEST(SineFit, FindsAnExactSineAtAKnownFrequency) {
  // sin(x + 0.3) = cos(x + 0.3 - pi/2); an offset of 30 mm leaves the input 3.5e-18 m of rounding
  const std::vector<double> signal = Samples(kRateHz, 2345, 0.03, {{2e-6, 225, 0.3}});
  const SineFit fit = FitSineAt(signal, {kRateHz, 0}, 225);
  ASSERT_TRUE(fit.converged);
  EXPECT_REL(fit.amplitude, 2e-6, 2e-13, "the input's rounding, 3.5e-18 m over sqrt(2345/2)");
  EXPECT_ABS(fit.phase_rad, 0.3 - kPi / 2, 2e-13, "the same over the amplitude");
  EXPECT_REL(fit.offset, 0.03, 3e-16, "one rounding");
  EXPECT_EQ(fit.frequency_hz, 225);
  EXPECT_EQ(fit.frequency_uncertainty_hz, 0);
  EXPECT_ABS(fit.residual_rms, 0, 4e-18, "the input's rounding at 30 mm");
}

TEST(SineFit, FindsTheFrequencyToo) {
  const std::vector<double> signal = Samples(kRateHz, 20'000, 0, {{2e-6, 225.123, -2}});
  for (const double start_hz : {225.123, 225.0, 225.3}) {
    const SineFit fit = FitSine(signal, {kRateHz, 0}, start_hz);
    ASSERT_TRUE(fit.converged) << start_hz;
    EXPECT_REL(fit.frequency_hz, 225.123, 1e-15, "phase rounding 1e-13 rad over 2 s");
    EXPECT_REL(fit.amplitude, 2e-6, 1e-14, "rounding");
    EXPECT_ABS(std::remainder(fit.phase_rad - (-2 - kPi / 2), 2 * kPi), 0, 1e-12,
               "rounding of phases of 3e3 rad");
  }
}

TEST(SineFit, SaysWhenItHasNotConverged) {
  const std::vector<double> signal = Samples(kRateHz, 20'000, 0, {{2e-6, 225, 0}});
  const SineFit far = FitSine(signal, {kRateHz, 0}, 240);
  EXPECT_FALSE(far.converged);
  EXPECT_TRUE(std::isnan(far.amplitude_uncertainty));
  EXPECT_FALSE(FitSine(std::vector<double>(4, 1.0), {kRateHz, 0}, 225).converged);
  EXPECT_FALSE(FitSineAt(std::vector<double>(20, 1.0), {kRateHz, 0}, 225).converged)
      << "20 samples at 10 kHz hold 0.45 periods";
  EXPECT_FALSE(FitSineAt(signal, {kRateHz, 0}, 5000).converged) << "half the rate";
}

// 400 noisy records: does the scatter agree with what each fit says of itself?
struct Scatter {
  double frequency_ratio = 0;  // standard deviation over stated uncertainty
  double amplitude_ratio = 0;
  double phase_ratio = 0;
};

Scatter ScatterOfFits(std::size_t count, double noise_bandwidth_hz, bool known) {
  constexpr int kRecords = 400;
  std::vector<double> frequencies;
  std::vector<double> amplitudes;
  std::vector<double> phases;
  SineFit fit;
  Noise noise(7);
  for (int r = 0; r < kRecords; ++r) {
    std::vector<double> signal = Samples(kRateHz, count, 0, {{1, 300, 0.5 + kPi / 2}});
    double held = 0;
    for (std::size_t k = 0; k < count; ++k) {
      // holding every value for two samples halves the noise's free samples
      if (noise_bandwidth_hz == 0 || k % 2 == 0) held = 0.3 * noise();
      signal[k] += held;
    }
    fit = known ? FitSineAt(signal, {kRateHz, noise_bandwidth_hz}, 300)
                : FitSine(signal, {kRateHz, noise_bandwidth_hz}, 300);
    EXPECT_TRUE(fit.converged);
    frequencies.push_back(fit.frequency_hz);
    amplitudes.push_back(fit.amplitude);
    phases.push_back(fit.phase_rad);
  }
  return {known ? 1 : StandardDeviation(frequencies) / fit.frequency_uncertainty_hz,
          StandardDeviation(amplitudes) / fit.amplitude_uncertainty,
          StandardDeviation(phases) / fit.phase_uncertainty_rad};
}

TEST(SineFit, StatedUncertaintiesAreTheScatter) {
  constexpr const char* kReason = "a deviation of 400 values is known to 3.5 %, four of these";
  const Scatter white = ScatterOfFits(1000, 0, false);
  EXPECT_ABS(white.frequency_ratio, 1, 0.14, kReason);
  EXPECT_ABS(white.amplitude_ratio, 1, 0.14, kReason);
  EXPECT_ABS(white.phase_ratio, 1, 0.14, kReason);
  const Scatter known = ScatterOfFits(1000, 0, true);
  EXPECT_ABS(known.amplitude_ratio, 1, 0.14, kReason);
  EXPECT_ABS(known.phase_ratio, 1, 0.14, kReason);
  const Scatter held = ScatterOfFits(1000, kRateHz / 4, false);
  EXPECT_ABS(held.frequency_ratio, 1, 0.14, kReason);
  EXPECT_ABS(held.amplitude_ratio, 1, 0.14, kReason);
}

TEST(SineFit, UncertaintiesAreTheClosedFormForWhiteNoise) {
  constexpr std::size_t kCount = 5000;
  std::vector<double> signal = Samples(kRateHz, kCount, 0, {{1, 300, 0}});
  Noise noise(3);
  for (double& x : signal) x += 0.1 * noise();
  const SineFit fit = FitSine(signal, {kRateHz, 0}, 300);
  const double s = fit.residual_rms;
  const double duration_s = kCount / kRateHz;
  EXPECT_REL(fit.amplitude_uncertainty, s * std::sqrt(2.0 / kCount), 1e-3, "N - 4 for N");
  EXPECT_REL(2 * kPi * fit.frequency_uncertainty_hz,
             s / fit.amplitude * std::sqrt(24.0 / kCount) / duration_s, 1e-3, "as above");
}

TEST(Tone, FindsTheStrongestOfTheBandAndNothingOutside) {
  const ToneSearch search{kRateHz, 20, 500, 0};
  const auto tone = StrongestTone(
      Samples(kRateHz, 20'000, 0.03, {{1e-6, 225.17, 1}, {3e-7, 450, 2}, {4e-6, 900}}), search);
  ASSERT_TRUE(tone);
  // side lobes fall as 1/(pi T distance): 4/(pi 2 675) and 0.3/(pi 2 225) of the amplitude
  EXPECT_REL(tone->amplitude, 1e-6, 1.2e-3, "side lobes of the other tones");
  EXPECT_REL(tone->frequency_hz, 225.17, 3e-6, "side lobes of the other tones");
}

TEST(Tone, EveryFrequencyBetweenTheBinsIsFound) {
  for (const double hz : {20.0, 21.3, 100.0, 100.25, 100.499, 100.5, 225.77, 499.9, 500.0}) {
    const auto tone =
        StrongestTone(Samples(kRateHz, 10'000, 0, {{1e-6, hz, 0.1}}), {kRateHz, 20, 500, 0});
    ASSERT_TRUE(tone) << hz;
    EXPECT_REL(tone->frequency_hz, hz, 1e-14, "rounding");
  }
}

TEST(Tone, NoiseIsNoTone) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Noise noise(seed);
    std::vector<double> signal(5000);
    for (double& x : signal) x = noise();
    if (StrongestTone(signal, {kRateHz, 20, 500, 0})) ++found;
  }
  EXPECT_LE(found, 2) << "1e-3 of 200 records";
  EXPECT_FALSE(StrongestTone(std::vector<double>(5000, 0.03), {kRateHz, 20, 500, 0}));
  EXPECT_FALSE(StrongestTone(Samples(kRateHz, 900, 0, {{1, 100}}), {kRateHz, 20, 500, 0}))
      << "0.09 s hold 1.8 periods of 20 Hz";
}

}  // namespace
}  // namespace haptometer::dsp
