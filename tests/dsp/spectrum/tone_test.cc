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

// An impulse has the same power in every bin (w h)^2; in phase with it, a tone on bin 200 adds its
// n / 4 to that bin. The median of 64 bins is (w h)^2, the mean of exponential values 1 / ln 2 of
// it, and one of m = 380 exceeds x times that mean with the probability m (1 + x / 32)^-32.
TEST(Tone, StandsOutOfItsNeighboursAsTheProbabilitySays) {
  constexpr std::size_t kSize = 1000;
  constexpr std::size_t kAt = 400;
  constexpr double kBins = 380;
  for (const double false_alarm : {1e-3, 0.05}) {
    const double x = 32 * (std::pow(kBins / false_alarm, 1.0 / 32) - 1);
    for (const double share : {0.999, 1.001}) {
      const double window = 0.5 - 0.5 * std::cos(2 * kPi * kAt / kSize);
      const double level = 1e-3 * window;
      const double amplitude = 4 * level * (std::sqrt(share * x / std::numbers::ln2) - 1) / kSize;
      const double w = 2 * kPi * 0.2;
      std::vector<double> signal =
          Samples(1000, kSize, 0, {{amplitude, 200, kPi / 2 - w * static_cast<double>(kAt)}});
      signal[kAt] += 1e-3;
      const ToneSearch search{1000, 20, 400, 0, false_alarm};
      EXPECT_EQ(StrongestTone(signal, search).has_value(), share > 1) << false_alarm;
    }
  }
}

// Of 40 samples no side has 16 bins. Beside the tone on bin 5, even about the middle, another on
// bin 15, which is odd, is what the fit leaves: u = b / sqrt(40 - 4). 150 Hz of 40 ms are six bins.
TEST(Tone, StandsOutOfTheResidualAsTheProbabilitySays) {
  const double ratio = std::sqrt(2 * std::log(6 / 1e-3));  // of the amplitude to u
  // amplitude and frequency share 0.06 of each other: u is 0.2 % larger
  for (const double share : {0.99, 1.01}) {
    std::vector<double> signal(40);
    for (std::size_t k = 0; k < signal.size(); ++k) {
      const double turn = 2 * kPi * (static_cast<double>(k) - 19.5) / 40;
      signal[k] = share * ratio / 6 * std::cos(5 * turn) + std::sin(15 * turn);
    }
    EXPECT_EQ(StrongestTone(signal, {1000, 50, 200, 0}).has_value(), share > 1) << share;
  }
}

TEST(Tone, NeedsTwoPeriodsOfTheLowerFrequency) {
  const std::vector<double> signal = Samples(kRateHz, 1000, 0, {{1e-6, 225, 0.1}});
  EXPECT_TRUE(StrongestTone(signal, {kRateHz, 20, 500, 0}));
  EXPECT_FALSE(StrongestTone(std::span(signal).first(999), {kRateHz, 20, 500, 0}));
}

// 10 times as strong, 0.9 bins of 1 Hz outside: in the outermost bin of the band its lobe is higher
// than in the second bin beside that, but lower than in the next one
TEST(Tone, TheShoulderOfAStrongerOneJustOutsideTheBandIsNone) {
  for (const double outside_hz : {19.1, 400.9}) {
    const auto tone = StrongestTone(Samples(1000, 1000, 0, {{10, outside_hz, 0.3}, {1, 210.3, 1}}),
                                    {1000, 20, 400, 0});
    ASSERT_TRUE(tone) << outside_hz;
    EXPECT_ABS(tone->frequency_hz, 210.3, 0.05, "side lobes of 10 / (pi 190) in the fit");
  }
}

// 2 rate / size times size / rate is below 2 for every fifth size
TEST(Tone, OfTwoPeriodsAtAnyLengthIsLookedFor) {
  for (std::size_t size = 10'000; size < 10'050; ++size) {
    const double lower_hz = 2 * kRateHz / static_cast<double>(size);
    const auto tone =
        StrongestTone(Samples(kRateHz, size, 0, {{1e-6, 8.3, 0.1}}), {kRateHz, lower_hz, 20, 0});
    ASSERT_TRUE(tone) << size;
    EXPECT_REL(tone->frequency_hz, 8.3, 1e-12, "rounding");
  }
}

// Six harmonics of which the second has an amplitude, and a tone that shares nothing with any of
// them: u = b / sqrt(n - 13) for each amplitude.
constexpr double kOther = 0.05;
const double kOfEach = kOther / std::sqrt(1000.0 - 13);

Harmonics WithSecond(double second) {
  const std::vector<double> signal =
      Samples(kRateHz, 1000, 0.03, {{1, 100, 0.3}, {second, 200, -1}, {kOther, 1010, 0.4}});
  return FitHarmonics(signal, {kRateHz, 0}, 100, 600);
}

TEST(Harmonics, UncertaintiesAreThoseOfWhatTheFitLeaves) {
  constexpr double kSecond = 0.02;
  const Harmonics found = WithSecond(kSecond);
  ASSERT_TRUE(found.converged && found.thd && found.thd_at_most);
  ASSERT_EQ(found.harmonics.size(), 6U);
  constexpr const char* kReason = "rounding of sums over whole periods";
  EXPECT_EQ(found.degrees_of_freedom, 987);
  EXPECT_REL(found.residual_rms, kOther / std::numbers::sqrt2, 1e-11, kReason);
  for (const Harmonic& h : found.harmonics) {
    EXPECT_REL(h.amplitude_uncertainty, kOfEach, 1e-10, kReason);
  }
  EXPECT_REL(found.harmonics[1].phase_uncertainty_rad, kOfEach / kSecond, 1e-10, kReason);
  // a^2 - 2 u^2 of five, over that of the first
  const double square = kOfEach * kOfEach;
  const double power = kSecond * kSecond - 5 * 2 * square;
  const double first = std::sqrt(1 - 2 * square);
  EXPECT_REL(*found.thd, std::sqrt(power) / first, 1e-10, kReason);
  // of amplitude^2 the variance 4 u^2 a^2 + 4 u^4, of the four others with nothing 4 u^4
  const double variance = 4 * square * (kSecond * kSecond - 2 * square) + 4 * square * square * 5;
  EXPECT_REL(found.thd_uncertainty,
             std::hypot(std::sqrt(variance / power) / 2, *found.thd * kOfEach) / first, 1e-10,
             kReason);
  EXPECT_REL(*found.thd_at_most,
             std::sqrt(power + 1.6448536269514722 * std::sqrt(variance)) / first, 1e-10, kReason);
}

// chi-squared of two degrees of freedom: 99 % below 2 ln(100) u^2
TEST(Harmonics, OneStandsOutOfNoiseInOneOfAHundred) {
  const double limit = kOfEach * std::sqrt(2 * std::log(100.0));
  EXPECT_FALSE(WithSecond(0.999 * limit).harmonics[1].stands_out);
  EXPECT_TRUE(WithSecond(1.001 * limit).harmonics[1].stands_out);
}

// chi-squared of ten degrees of freedom: exp(-x/2) (1 + x/2 + ... (x/2)^4 / 4!) is 1 % at 23.2093
TEST(Harmonics, TogetherTheyStandOutOfNoiseInOneOfAHundred) {
  const double limit = kOfEach * std::sqrt(23.209251158954356);
  EXPECT_FALSE(WithSecond(0.999 * limit).thd);
  EXPECT_TRUE(WithSecond(0.999 * limit).thd_at_most);
  EXPECT_TRUE(WithSecond(1.001 * limit).thd);
}

TEST(Harmonics, NeedAPeriodAndMoreSamplesThanParameters) {
  const std::vector<double> signal = Samples(kRateHz, 1000, 0, {{1, 100, 0.3}, {0.1, 200}});
  EXPECT_TRUE(FitHarmonics(std::span(signal).first(100), {kRateHz, 0}, 100, 100).converged);
  EXPECT_FALSE(FitHarmonics(std::span(signal).first(99), {kRateHz, 0}, 100, 100).converged);
  // of 1000 samples in a band of 25 Hz five are independent: two harmonics and an offset are five
  EXPECT_FALSE(FitHarmonics(signal, {kRateHz, 25}, 100, 200).converged);
  const Harmonics found = FitHarmonics(signal, {kRateHz, 30}, 100, 200);
  ASSERT_TRUE(found.converged);
  EXPECT_REL(found.degrees_of_freedom, 1, 1e-12, "six independent samples less five parameters");
}

TEST(ToneDeathTest, RatesFrequenciesAndDegreesAreChecked) {
  const std::vector<double> signal = Samples(kRateHz, 1000, 0, {{1, 100, 0.3}});
  EXPECT_DEATH(static_cast<void>(StrongestTone(signal, {0, 20, 500, 0})), "check failed");
  EXPECT_DEATH(static_cast<void>(StrongestTone(signal, {kRateHz, 0, 500, 0})), "check failed");
  EXPECT_DEATH(static_cast<void>(FitHarmonics(signal, {0, 0}, 100, 500)), "check failed");
  EXPECT_DEATH(static_cast<void>(FitHarmonics(signal, {kRateHz, 0, -1}, 100, 500)), "check failed");
  EXPECT_DEATH(
      static_cast<void>(FitHarmonics(signal, {kRateHz, 0, kHighestDriftDegree + 1}, 100, 500)),
      "check failed");
  EXPECT_TRUE(FitHarmonics(signal, {kRateHz, 0, kHighestDriftDegree}, 100, 500).converged);
}

}  // namespace
}  // namespace haptometer::dsp
