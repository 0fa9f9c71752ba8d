#include "dsp/spectrum/tone.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRateHz = 10e3;

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

// how many of `records` noise records show a tone; `pink` falls as 1/f in power
int FalseAlarms(int records, std::size_t count, const ToneSearch& search, bool pink) {
  int found = 0;
  Noise noise(77);
  std::vector<double> signal(count);
  for (int r = 0; r < records; ++r) {
    // Kellet's three poles make white noise pink within 0.5 dB above a hundredth of the rate's half
    double a = 0;
    double b = 0;
    double c = 0;
    for (double& x : signal) {
      x = noise();
      if (!pink) continue;
      a = 0.99765 * a + x * 0.0990460;
      b = 0.96300 * b + x * 0.2965164;
      c = 0.57000 * c + x * 1.0526913;
      x = a + b + c + x * 0.1848;
    }
    found += StrongestTone(signal, search) ? 1 : 0;
  }
  return found;
}

TEST(Tone, FalseAlarmsAreAsOftenAsStated) {
  // judged by 64 neighbours on the noisier of two sides: never more, and not far less
  const int found = FalseAlarms(2000, 1000, {1000, 20, 400, 0, 0.05}, false);
  EXPECT_LE(found, 100 + 30) << "5 % of 2000, three deviations";
  EXPECT_GE(found, 5) << "15 here: a bound that is careful, not blind";
  // judged by the residual: 13 bins, of which 7 are the peak's own
  const int few = FalseAlarms(2000, 300, {1000, 10, 50, 0, 0.05}, false);
  EXPECT_LE(few, 100 + 30);
  EXPECT_GE(few, 20);
}

TEST(Tone, PinkNoiseIsNoTone) {
  EXPECT_LE(FalseAlarms(300, 1500, {1000, 20, 400, 0, 0.01}, true), 8) << "1 % of 300";
}

TEST(Tone, IsFoundInSpiteOfBurstAndDecay) {
  // a struck fork: 439.15 Hz dying away over a fifth of the record, a burst at its start
  constexpr std::size_t kCount = 50'000;
  std::vector<double> signal(kCount);
  Noise noise(8);
  for (std::size_t k = 0; k < kCount; ++k) {
    const double t_s = static_cast<double>(k) / kRateHz;
    signal[k] = std::exp(-t_s) * std::cos(2 * kPi * 439.15 * t_s) + 0.01 * noise();
    if (k < 300) signal[k] += 20 * noise();
  }
  const auto tone = StrongestTone(signal, {kRateHz, 20, 500, 0});
  ASSERT_TRUE(tone);
  EXPECT_ABS(tone->frequency_hz, 439.15, 0.02, "a tenth of 1/duration: the burst");
}

TEST(Tone, BesideAStrongerOneOutsideTheBandIsFound) {
  // tremor ten times larger below the band
  const auto tone = StrongestTone(Samples(kRateHz, 20'000, 0, {{1e-5, 8.3, 1}, {1e-6, 225.2, 2}}),
                                  {kRateHz, 20, 500, 0});
  ASSERT_TRUE(tone);
  EXPECT_ABS(tone->frequency_hz, 225.2, 0.02, "the tremor's side lobes in the unwindowed fit");
}

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
