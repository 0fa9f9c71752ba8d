#include "dsp/analysis/clipping.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

using enum ClippingVerdict;

std::vector<double> Tone(double rate_hz, double tone_hz, double noise_m, std::uint64_t seed,
                         double second_m = 0) {
  std::vector<double> values = Samples(
      rate_hz, static_cast<std::size_t>(2 * rate_hz), 0,
      {{50e-6, tone_hz, 0.1 * static_cast<double>(seed)}, {second_m, 2 * tone_hz, 1.3}, {2e-5, 6}});
  Noise noise(seed);
  for (double& x : values) x += noise_m * noise();
  return values;
}

void Clip(std::vector<double>& values, double most) {
  for (double& x : values) x = std::min(x, most);
}

TEST(Clipping, FewSamplesAPeriodAreEnough) {
  // six samples a period at 331 Hz: a rail at 0.6 of the amplitude holds 29 % of them
  for (const double noise_m : {0.0, 2e-7}) {
    for (const double tone_hz : {331.0, 287.3, 175.7, 90.1, 440.3}) {
      std::vector<double> values = Tone(2000, tone_hz, noise_m, 1);
      Clip(values, 3e-5);
      const Clipping clipping = FindClipping(values, 2000, tone_hz);
      EXPECT_EQ(clipping.verdict, kClipped) << tone_hz;
      EXPECT_EQ(clipping.high_rail, 3e-5);
      EXPECT_FALSE(clipping.low_rail);
      EXPECT_ABS(clipping.share, 0.27, 0.06, "drift moves the tone against the rail");
    }
  }
}

// clean tones, commensurate with the rate or not: none of 60 is called clipped
TEST(Clipping, CleanTonesAreNot) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    for (const double tone_hz : {400.0, 250.0, 331.0, 500.0, 123.4}) {
      for (const double noise_m : {0.0, 2e-7}) {
        std::vector<double> values = Tone(2000, tone_hz, noise_m, seed);
        // steps of 2 um put many samples on the highest
        if (seed % 2 == 0) {
          for (double& x : values) x = std::round(x / 2e-6) * 2e-6;
        }
        EXPECT_NE(FindClipping(values, 2000, tone_hz).verdict, kClipped) << tone_hz << " " << seed;
      }
    }
  }
}

TEST(Clipping, ACommensurateToneIsUndecided) {
  // five phases: without the railed ones they do not determine the harmonics
  std::vector<double> values = Samples(2000, 4000, 0, {{50e-6, 400, 0.3}});
  Clip(values, 3e-5);
  EXPECT_EQ(FindClipping(values, 2000, 400).verdict, kUndecided);
}

TEST(Clipping, HarmonicsAreNoRail) {
  std::vector<double> values = Tone(10e3, 175, 0, 1, 1.2e-5);
  EXPECT_EQ(FindClipping(values, 10e3, 175).verdict, kNone);
  EXPECT_EQ(FindClipping({}, 10e3, 175).verdict, kNone);
  EXPECT_EQ(FindClipping(std::vector<double>(500, 1.0), 10e3, 175).verdict, kNone);
}

}  // namespace
}  // namespace haptometer::dsp
