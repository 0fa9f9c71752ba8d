// The oracle is the closed form: the frequency at the middle of each frame.
#include "dsp/spectrum/ridge.h"

#include <gtest/gtest.h>

#include <cmath>
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

}  // namespace
}  // namespace haptometer::dsp
