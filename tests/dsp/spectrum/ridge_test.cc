// The oracle is the closed form: the frequency at the middle of each frame.
#include "dsp/spectrum/ridge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <span>
#include <vector>

#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 2600;
constexpr std::size_t kFrame = 260;
constexpr double kBinCost = 0.02;

std::vector<double> RidgeOf(const std::vector<double>& samples) {
  const auto frame = [&](std::size_t k) {
    return std::span(samples).subspan(k * kFrame / 2, kFrame);
  };
  return FindRidge({frame, samples.size() / (kFrame / 2) - 1, kRateHz}, 20, 500, kBinCost);
}

// cos of a phase whose frequency changes linearly, from and to hertz
std::vector<double> Chirp(double from_hz, double to_hz, std::size_t count) {
  std::vector<double> samples(count);
  const double seconds = static_cast<double>(count) / kRateHz;
  for (std::size_t n = 0; n < count; ++n) {
    const double t = static_cast<double>(n) / kRateHz;
    samples[n] =
        std::cos(2 * std::numbers::pi * (from_hz + 0.5 * (to_hz - from_hz) * t / seconds) * t);
  }
  return samples;
}

TEST(Ridge, FollowsAToneThatMoves) {
  const std::size_t count = 26'000;
  const std::vector<double> ridge = RidgeOf(Chirp(150, 400, count));
  for (std::size_t k = 0; k < ridge.size(); ++k) {
    const std::size_t middle_sample = (k + 1) * (kFrame / 2);
    const double middle = static_cast<double>(middle_sample) / static_cast<double>(count);
    EXPECT_ABS(ridge[k], 150 + 250 * middle, kRateHz / 2048,
               "a bin: at its ends the path saves the cost of the last move");
  }
}

TEST(Ridge, JumpsToAnotherTone) {
  std::vector<double> samples = Chirp(100, 100, 5200);
  const std::vector<double> second = Chirp(350, 350, 5200);
  samples.insert(samples.end(), second.begin(), second.end());
  const std::vector<double> ridge = RidgeOf(samples);
  EXPECT_ABS(ridge.front(), 100.0, 0.5, "a twentieth of the window's 1 / 0.1 s");
  EXPECT_ABS(ridge.back(), 350.0, 0.5, "a twentieth of the window's 1 / 0.1 s");
}

// a burst at another frequency for one frame costs two jumps, which its magnitude does not pay
TEST(Ridge, PassesABurst) {
  std::vector<double> samples = Chirp(100, 100, 5200);
  for (std::size_t n = 2600; n < 2600 + kFrame; ++n) {
    samples[n] += 1.2 * std::cos(2 * std::numbers::pi * 350 * static_cast<double>(n) / kRateHz);
  }
  for (const double frequency_hz : RidgeOf(samples)) {
    EXPECT_ABS(frequency_hz, 100.0, 2.0, "leakage of the burst");
  }
}

TEST(Ridge, OfNothingIsNothing) { EXPECT_TRUE(FindRidge({}, 20, 500, kBinCost).empty()); }

// twenty frames of a tone of 100 Hz; ten of them have another one of 350 Hz, too
std::vector<double> WithAnother(double amplitude) {
  std::vector<std::vector<double>> frames(20, std::vector<double>(kFrame));
  for (std::size_t k = 0; k < frames.size(); ++k) {
    for (std::size_t n = 0; n < kFrame; ++n) {
      const double turn = 2 * std::numbers::pi * static_cast<double>(n) / kRateHz;
      frames[k][n] = std::cos(100 * turn);
      if (k >= 5 && k < 15) frames[k][n] += amplitude * std::cos(350 * turn);
    }
  }
  const auto frame = [&](std::size_t k) { return std::span<const double>(frames[k]); };
  return FindRidge({frame, frames.size(), kRateHz}, 20, 500, kBinCost);
}

// the other tone is the largest magnitude M: 10 (M - 1) against two jumps of M, so from 1.25 on
TEST(Ridge, AJumpCostsTheLargestMagnitude) {
  for (const double amplitude : {1.23, 1.27}) {
    const std::vector<double> ridge = WithAnother(amplitude);
    for (std::size_t k = 0; k < ridge.size(); ++k) {
      const bool is_other = amplitude > 1.25 && k >= 5 && k < 15;
      EXPECT_ABS(ridge[k], is_other ? 350.0 : 100.0, 0.5, "a twentieth of the window's 10 Hz") << k;
    }
  }
}

// a tone between bins of 1.27 Hz, anywhere
TEST(Ridge, LiesBetweenTheBins) {
  for (double tone_hz = 200; tone_hz < 202.6; tone_hz += 0.2) {
    for (const double frequency_hz : RidgeOf(Chirp(tone_hz, tone_hz, 1300))) {
      EXPECT_ABS(frequency_hz, tone_hz, 0.01, "a parabola for the logarithm of Hann's lobe");
    }
  }
}

constexpr double kBinHz = 2;  // of frames of 256 samples at 2048 Hz, with zeros up to 1024

// one frame of each tone, whose frequencies are given in bins; silence where one is 0
std::vector<double> RidgeOfBins(const std::vector<double>& tones, double amplitude, double lower_hz,
                                double upper_hz, double bin_cost) {
  std::vector<std::vector<double>> frames(tones.size(), std::vector<double>(256));
  for (std::size_t k = 0; k < tones.size(); ++k) {
    for (std::size_t n = 0; tones[k] > 0 && n < frames[k].size(); ++n) {
      const double turns = tones[k] * static_cast<double>(n) / 1024;
      frames[k][n] = amplitude * std::cos(2 * std::numbers::pi * turns);
    }
  }
  const auto frame = [&](std::size_t k) { return std::span<const double>(frames.at(k)); };
  return FindRidge({frame, frames.size(), 2048}, lower_hz, upper_hz, bin_cost);
}

// what a bin beside the tone's lacks of its magnitude
double MissingBeside() {
  std::complex<double> beside;
  double peak = 0;
  for (int n = 0; n < 256; ++n) {
    const double weight = std::pow(std::sin(std::numbers::pi * (n + 0.5) / 256), 2);
    beside += weight * std::polar(1.0, 2 * std::numbers::pi * n / 1024);
    peak += weight;
  }
  return 1 - std::abs(beside) / peak;
}

// A tone moves by one bin for the last frame: to follow it costs `bin_cost`, to stay what is
// missing there, and then the parabola's top lies at the border of both bins.
TEST(Ridge, AMoveOfABinCostsItsShareOfTheLargestMagnitude) {
  for (const double amplitude : {1.0, 30.0}) {
    for (const double step : {-1.0, 1.0}) {
      for (const double share : {0.995, 1.005}) {
        const auto ridge = RidgeOfBins({300, 300, 300, 300, 300, 300 + step}, amplitude, 100, 1000,
                                       share * MissingBeside());
        EXPECT_ABS(ridge[4], 300 * kBinHz, 1e-4, "a tone on a bin; leakage of -f");
        EXPECT_ABS(ridge[5], (300 + (share < 1 ? step : 0.5 * step)) * kBinHz, 1e-4,
                   "a tone on a bin, or the limit of half a bin");
      }
    }
  }
}

// two bins for three frames: the second bin costs as much as the first
TEST(Ridge, AMoveOfTwoBinsCostsTwice) {
  for (const double step : {-1.0, 1.0}) {
    for (const double share : {0.995, 1.005}) {
      const double to = 300 + 2 * step;
      const auto ridge = RidgeOfBins({300, 300, 300, 300, 300, to, to, to}, 1, 100, 1000,
                                     share * 3 * MissingBeside());
      EXPECT_ABS(ridge[4], 300 * kBinHz, 1e-4, "a tone on a bin; leakage of -f");
      for (std::size_t k = 5; k < ridge.size(); ++k) {
        EXPECT_ABS(ridge[k], (300 + (share < 1 ? 2 : 1.5) * step) * kBinHz, 1e-4,
                   "a tone on a bin, or the limit of half a bin");
      }
    }
  }
}

TEST(Ridge, OfATonesLobeTheParabolasTopIsTheTone) {
  for (const double off : {-0.4, -0.25, 0.1, 0.25, 0.4}) {
    const auto ridge = RidgeOfBins({300 + off}, 1, 100, 1000, kBinCost);
    ASSERT_EQ(ridge.size(), 1U);
    EXPECT_ABS(ridge[0] / kBinHz, 300 + off, 8e-4, "the lobe's logarithm is not quite a parabola");
  }
}

// Both ends are included. The outermost bin has no neighbours for a parabola; bins end before half
// the rate.
TEST(Ridge, LiesWithinTheStatedFrequencies) {
  const auto of = [](double bin, double lower_hz, double upper_hz) {
    return RidgeOfBins({bin, bin, bin}, 1, lower_hz, upper_hz, kBinCost);
  };
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(of(300, 600, 900)[k], 600);
    EXPECT_EQ(of(300, 599.9, 900)[k], 600);
    EXPECT_EQ(of(300, 600.1, 900)[k], 602);
    EXPECT_EQ(of(300, 400, 600)[k], 600);
    EXPECT_EQ(of(300, 400, 601.9)[k], 600);
    EXPECT_EQ(of(300, 400, 599.9)[k], 598);
    EXPECT_EQ(of(512, 400, 1024)[k], 1022);
  }
}

TEST(Ridge, StaysWhereItWasInSilence) {
  const auto ridge = RidgeOfBins({300, 300, 0, 0}, 1, 100, 1000, kBinCost);
  EXPECT_EQ(ridge[2], 600);
  EXPECT_EQ(ridge[3], 600);
}

}  // namespace
}  // namespace haptometer::dsp
