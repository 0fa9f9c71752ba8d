// Clipping against tones whose rails are known.
#include "dsp/readings/clipping.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
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

// In steps of 2 um the rail is not ten times as frequent as another value: the fit decides, by how
// far it lies beyond the rail and how well the other samples determine it there.
TEST(Clipping, OfRoundedSamplesIsFoundByTheFit) {
  for (const double tone_hz : {331.0, 287.3, 175.7, 90.1, 440.3}) {
    std::vector<double> values = Tone(2000, tone_hz, 2e-7, 1);
    Clip(values, 4.6e-5);
    for (double& x : values) x = std::round(x / 2e-6) * 2e-6;
    EXPECT_EQ(FindClipping(values, 2000, tone_hz).verdict, kClipped) << tone_hz;
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

// 10 to 20 phases that repeat from period to period, and with them what rounding does to each: in
// steps of 0.1 um, and as numbers of seven digits are printed
TEST(Clipping, CommensurateRoundedTonesAreNot) {
  for (const double tone_hz : {250.0, 500.0, 312.5}) {
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
      std::vector<double> values =
          Samples(5000, 12'500, 0, {{20e-6, tone_hz, 0.3 * static_cast<double>(seed)}});
      Noise noise(seed);
      for (double& x : values) x = std::round((x + 1e-8 * noise()) / 1e-7) * 1e-7;
      EXPECT_EQ(FindClipping(values, 5000, tone_hz).verdict, kNone) << tone_hz << " " << seed;
      values = Samples(5000, 12'500, 0, {{20e-6, tone_hz, 0.3 * static_cast<double>(seed)}});
      for (double& x : values) x = static_cast<double>(static_cast<float>(x));
      EXPECT_EQ(FindClipping(values, 5000, tone_hz).verdict, kNone) << tone_hz << " " << seed;
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

// sin^2 of a third of each period, else at rest; and exp(q (cos - 1)), whose harmonics end below a
// step: in steps, nearly all of the rest is one value
TEST(Clipping, PulsesBetweenRestsAreNotClipped) {
  const double turn = 2 * std::numbers::pi;
  for (const double step : {1e-8, 1e-7, 1e-6}) {
    for (const double tone_hz : {81.3, 117.9}) {
      std::vector<double> pulses(20'000), bells(20'000);
      for (std::size_t k = 0; k < pulses.size(); ++k) {
        const double turns = std::fmod(tone_hz * 1e-4 * static_cast<double>(k), 1);
        pulses[k] = turns < 0.33 ? std::pow(std::sin(turn / 2 * turns / 0.33), 2) : 0;
        bells[k] = std::exp(4 * (std::cos(turn * turns) - 1));
      }
      for (std::vector<double>* values : {&pulses, &bells}) {
        Noise noise(1);
        for (double& x : *values) {
          x = std::round((20e-6 * x + 3e-3 + 2e-9 * noise()) / step) * step;
        }
        EXPECT_NE(FindClipping(*values, 10e3, tone_hz).verdict, kClipped) << step << ' ' << tone_hz;
      }
    }
  }
}

// at a rail for 51 to 63 % of each period, the other half of a sine is left
TEST(Clipping, AToneLimitedForMostOfItsPeriodIsClipped) {
  for (const double limit_m : {-8e-6, -2e-6, -3e-7}) {
    for (const double step : {1e-8, 1e-7}) {
      for (const double tone_hz : {51.3, 113.7, 231.9}) {
        std::vector<double> values = Samples(10e3, 20'000, 0, {{20e-6, tone_hz}});
        for (double& x : values) x = std::round(std::min(x, limit_m) / step) * step;
        EXPECT_EQ(FindClipping(values, 10e3, tone_hz).verdict, kClipped)
            << limit_m << ' ' << step << ' ' << tone_hz;
      }
    }
  }
}

// A tone of 20 um with noise that an amplifier does not pass beyond its limits, and the noise of a
// converter, which has steps of 0.15 um.
TEST(Clipping, BelowNoiseIsFound) {
  struct Case {
    double low_m, high_m, noise_m, tone_hz, modulation, share;
  };
  constexpr double kNone = -1;
  // shares: acos(limit / amplitude) / pi of each side
  for (const Case& is :
       {Case{kNone, 14e-6, 3e-7, 175, 0, 0.253}, Case{-14e-6, 14e-6, 2e-7, 175, 0, 0.506},
        Case{-10e-6, 10e-6, 1e-6, 175, 0, 0.667}, Case{-18e-6, kNone, 2e-7, 92.4, 0, 0.144},
        Case{kNone, 1e-7, 2e-7, 203.3, 0, 0.498}, Case{kNone, 12e-6, 2e-7, 310.1, 0.3, 0.295}}) {
    std::vector<double> values = Samples(10e3, 20'000, 0, {{20e-6, is.tone_hz}});
    Noise noise(3);
    for (std::size_t k = 0; k < values.size(); ++k) {
      values[k] *=
          1 + is.modulation * std::sin(2 * std::numbers::pi * 2e-4 * static_cast<double>(k));
      values[k] = std::clamp(values[k] + 1e-7 * noise(), is.low_m == kNone ? -1 : is.low_m,
                             is.high_m == kNone ? 1 : is.high_m);
      values[k] = 3e-3 + std::round((values[k] + is.noise_m * noise()) / 1.5e-7) * 1.5e-7;
    }
    const Clipping found = FindClipping(values, 10e3, is.tone_hz);
    EXPECT_EQ(found.verdict, kBelowNoise) << is.low_m << ' ' << is.high_m;
    EXPECT_EQ(found.low_rail.has_value(), is.low_m != kNone);
    EXPECT_EQ(found.high_rail.has_value(), is.high_m != kNone);
    if (found.low_rail) {
      EXPECT_ABS(*found.low_rail - 3e-3, is.low_m, 3e-7, "two steps");
    }
    if (found.high_rail) {
      EXPECT_ABS(*found.high_rail - 3e-3, is.high_m, 3e-7, "two steps");
    }
    EXPECT_ABS(found.share, is.share, 0.02, "flanks within the noise");
  }
}

TEST(Clipping, BelowNoiseIsNotInWavesOfOtherShapes) {
  const double turn = 2 * std::numbers::pi;
  for (int shape = 0; shape < 8; ++shape) {
    for (const double relative_noise : {1e-3, 2e-2}) {
      const double tone_hz = 97.3 + 40 * shape;
      std::vector<double> values(10'000);
      Noise noise(static_cast<std::uint64_t>(shape));
      for (std::size_t k = 0; k < values.size(); ++k) {
        const double t_s = static_cast<double>(k) / 1e4;
        const double sine = std::sin(turn * tone_hz * t_s);
        const double shapes[] = {
            sine,
            2 / std::numbers::pi * std::asin(sine),       // triangle
            std::tanh(3 * sine),                          // rounded square
            sine - 0.3 * sine * sine * sine,              // as a stiffening spring makes it
            sine * (1 + 0.6 * std::sin(turn * 3 * t_s)),  // modulated
            sine + 3 * std::sin(turn * 7 * t_s),          // with tremor
            sine * std::exp(-8 * std::fmod(t_s, 0.5)),    // ringing down
            t_s < 0.6 ? sine : 0};                        // switched off
        values[k] = 20e-6 * (shapes[shape] + relative_noise * noise());
      }
      EXPECT_EQ(FindClipping(values, 1e4, tone_hz).verdict, kNone) << shape << relative_noise;
      for (double& x : values) x = std::round(x / 1e-6) * 1e-6;
      EXPECT_EQ(FindClipping(values, 1e4, tone_hz).verdict, kNone) << shape << relative_noise;
    }
  }
}

// a block holds a whole period of it, which a quartic leaves 6.6 % of
TEST(Clipping, BelowNoiseIsNotInTremorOfAHundredTimesTheTone) {
  const double turn = 2 * std::numbers::pi;
  for (const double tremor_hz : {7.3, 9.8}) {
    for (const double tone_hz : {226.6, 283.7}) {
      std::vector<double> values(12'000);
      Noise noise(1);
      for (std::size_t k = 0; k < values.size(); ++k) {
        const double t_s = static_cast<double>(k) / 1e4;
        const double phase = turn * tremor_hz * t_s - 0.6 * std::cos(turn * 0.4 * t_s);
        values[k] =
            10e-6 * (std::sin(turn * tone_hz * t_s) + 100 * std::sin(phase) + 0.01 * noise());
      }
      EXPECT_EQ(FindClipping(values, 1e4, tone_hz).verdict, kNone) << tremor_hz << " " << tone_hz;
    }
  }
}

// of 20 000 samples of noise and a tone the highest `count` at one value: more than a thousandth of
// them, and ten times as many as any other value
TEST(Clipping, IsOfMoreThanAThousandthOfTheSamples) {
  std::vector<double> values = Samples(10e3, 20'000, 0, {{50e-6, 175.3, 0.2}});
  Noise noise(3);
  for (double& x : values) x += 1e-6 * noise();
  std::vector<double> sorted = values;
  std::ranges::sort(sorted);
  for (const std::size_t count : {20U, 21U}) {
    std::vector<double> clipped = values;
    Clip(clipped, sorted[sorted.size() - count]);
    const Clipping clipping = FindClipping(clipped, 10e3, 175.3);
    EXPECT_EQ(clipping.verdict, count == 21 ? kClipped : kNone) << count;
    EXPECT_EQ(clipping.share, count == 21 ? 21 / 20e3 : 0);
    EXPECT_EQ(clipping.high_rail.has_value(), count == 21);
  }
}

}  // namespace
}  // namespace haptometer::dsp
