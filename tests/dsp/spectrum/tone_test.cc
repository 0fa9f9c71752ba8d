#include "dsp/spectrum/tone.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
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

}  // namespace
}  // namespace haptometer::dsp
