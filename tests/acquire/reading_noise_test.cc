#include "acquire/reading_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "tests/residual.h"

// Noise of readings that overlap, and images of a staircase, against closed forms.

namespace haptometer::acquire {
namespace {

TEST(NoiseDensity, OfReadingsThatDoNotOverlapIsWhite) {
  for (const double frequency_hz : {0.0, 20.0, 61.0}) {
    EXPECT_REL(NoiseDensity({122, 3e-6, 0}, frequency_hz), 2 * 9e-12 / 122, 1e-15, "a product");
    EXPECT_REL(NoiseDensity({122, 3e-6, 1.0 / 122}, frequency_hz), 2 * 9e-12 / 122, 1e-15,
               "one after the other");
  }
}

// n raw samples of noise s, averaged at each raw sample: 2 s^2 T times the moving mean's gain,
// where a reading's own noise is s / sqrt(n)
TEST(NoiseDensity, OfAMovingMeanIsTheRawNoiseTimesItsGain) {
  constexpr double kSampling_s = 1e-3;
  constexpr double kRaw_m = 11e-6;
  for (const int n : {2, 4, 16}) {
    for (const double frequency_hz : {3.0, 20.0, 90.0}) {
      const double half_angle = std::numbers::pi * frequency_hz * kSampling_s;
      const double gain = std::sin(n * half_angle) / (n * std::sin(half_angle));
      EXPECT_REL(
          NoiseDensity({1 / kSampling_s, kRaw_m / std::sqrt(n), n * kSampling_s}, frequency_hz),
          2 * kRaw_m * kRaw_m * kSampling_s * gain * gain, 1e-11,
          "differences of 16 cosines where the gain is small");
    }
  }
}

// a staircase sampled ever faster: 2 s^2 T sinc^2(f T)
TEST(NoiseDensity, OfAStaircaseIsThatOfItsHold) {
  constexpr double kStep_s = 0.33e-3;
  const double x = std::numbers::pi * 225 * kStep_s;
  const double held = 2 * 121e-12 * kStep_s * std::pow(std::sin(x) / x, 2);
  EXPECT_REL(NoiseDensity({1e6, 11e-6, kStep_s}, 225), held, 1e-5,
             "the rectangle rule at 330 points of a triangle: (1 / 330)^2");
}

// the mean of the density over all frequencies is the variance
TEST(NoiseDensity, AddsUpToTheVariance) {
  constexpr int kPoints = 1000;
  double sum = 0;
  for (int k = 0; k < kPoints; ++k) sum += NoiseDensity({400, 2e-6, 13e-3}, (k + 0.5) * 0.2);
  EXPECT_REL(sum * 0.2, 4e-12, 1e-12, "whole periods of each cosine");
}

TEST(ImagesInBand, OfTheFirstRenewal) {
  // 1 / 0.33 ms = 3030.30 Hz: images at 2805.30 and 3255.30 Hz; at 3 kHz they fold to 194.70 and
  // 255.30 Hz with 225 / 2805.30 and 225 / 3255.30 of the amplitude
  const auto images = ImagesInBand({0.33e-3, 225, 3000}, 20, 500, 0.05);
  ASSERT_EQ(images.size(), 2U);
  EXPECT_REL(images[0].image_hz, 2805.3030303, 1e-9, "eleven digits");
  EXPECT_REL(images[0].folded_hz, 194.6969697, 1e-9, "ten digits");
  EXPECT_REL(images[0].relative, 225 / 2805.3030303, 1e-9, "a quotient");
  EXPECT_REL(images[1].folded_hz, 255.3030303, 1e-9, "ten digits");
  EXPECT_LT(images[1].relative, images[0].relative);
}

TEST(ImagesInBand, AreNoneWhereTheyFoldElsewhere) {
  // at 10 kHz: 2805 and 3255 Hz stay; 5836 and 6286 to 4164 and 3714; ... down to 5 % nothing
  EXPECT_TRUE(ImagesInBand({0.33e-3, 225, 10'000}, 20, 500, 0.05).empty());
}

// the images of a simulated staircase, by the sums of its own samples
TEST(ImagesInBand, AreThoseOfASampledStaircase) {
  constexpr HeldOutput kHeld{0.33e-3, 225, 3000};
  const FoldedImage image = ImagesInBand(kHeld, 20, 500, 0.05).front();
  const auto amplitude_at = [&](double frequency_hz) {
    constexpr int kSamples = 99'000;  // 33 s: whole periods of all that is there
    double cosine = 0;
    double sine = 0;
    for (int i = 0; i < kSamples; ++i) {
      const double t_s = i / kHeld.daq_rate_hz;
      // 100 daq samples are 101.0101.. steps: a small shift keeps instants off the edges
      const double step_s = std::floor(t_s / kHeld.sampling_s + 1e-6) * kHeld.sampling_s;
      const double value = std::cos(2 * std::numbers::pi * kHeld.frequency_hz * step_s);
      cosine += value * std::cos(2 * std::numbers::pi * frequency_hz * t_s);
      sine += value * std::sin(2 * std::numbers::pi * frequency_hz * t_s);
    }
    return std::hypot(cosine, sine);
  };
  EXPECT_REL(amplitude_at(image.folded_hz) / amplitude_at(kHeld.frequency_hz), image.relative, 0.02,
             "99 phases of a step are met, not all");
}

TEST(UnfoldedRateHz, IsTheLowestThatFoldsNothing) {
  const HeldOutput held{.sampling_s = 0.33e-3, .frequency_hz = 225};
  const double rate_hz = UnfoldedRateHz(held, 20, 500, 0.01, 1280);
  HeldOutput at = held;
  at.daq_rate_hz = rate_hz;
  EXPECT_TRUE(ImagesInBand(at, 20, 500, 0.01).empty());
  for (const double lower_hz : {2000.0, 5000.0, 10'000.0}) {
    if (lower_hz >= rate_hz) break;
    at.daq_rate_hz = lower_hz;
    EXPECT_FALSE(ImagesInBand(at, 20, 500, 0.01).empty()) << lower_hz;
  }
}

// at 1 ms the first image of 484 Hz, 516 Hz, is in the band at any rate: no rate folds it
TEST(UnfoldedRateHz, EndsWhereAnImageIsInTheBandByItself) {
  EXPECT_LE(UnfoldedRateHz({.sampling_s = 1e-3, .frequency_hz = 484}, 20, 550, 0.01, 1400),
            200'000);
}

// f / (k / T -+ 212 Hz) >= 0.01 up to k / T = 21 200 +- 212 Hz: k T^-1 of 7 below and of 6 above
TEST(ImagesInBand, AreAllThatHaveEnoughOfTheTone) {
  const auto images = ImagesInBand({0.33e-3, 212, 1000}, 0, 500, 0.01);
  ASSERT_EQ(images.size(), 13U);
  EXPECT_REL(images.front().relative, 212 / (1 / 0.33e-3 - 212), 1e-12, "a quotient");
  EXPECT_REL(images.back().relative, 212 / (7 / 0.33e-3 - 212), 1e-12, "a quotient");
  // 225 / 3255.30 = 0.06912
  EXPECT_EQ(ImagesInBand({0.33e-3, 225, 3000}, 20, 500, 0.0690).size(), 2U);
  EXPECT_EQ(ImagesInBand({0.33e-3, 225, 3000}, 20, 500, 0.0692).size(), 1U);
}

TEST(ImagesInBand, AreWithinTheBand) {
  // folded to 194.70 and 255.30 Hz
  EXPECT_EQ(ImagesInBand({0.33e-3, 225, 3000}, 194, 256, 0.05).size(), 2U);
  EXPECT_EQ(ImagesInBand({0.33e-3, 225, 3000}, 195, 256, 0.05).size(), 1U);
  EXPECT_EQ(ImagesInBand({0.33e-3, 225, 3000}, 194, 255, 0.05).size(), 1U);
}

TEST(ImagesInBand, TheirLimitsBelongToThem) {
  // renewals at 1024 Hz: images of 24 Hz at 1000 Hz, half the rate and not folded, and at 1048 Hz,
  // folded to 952 Hz
  const HeldOutput held{.sampling_s = 0x1p-10, .frequency_hz = 24, .daq_rate_hz = 2000};
  for (const auto& [lower_hz, upper_hz] :
       {std::pair(952.0, 1000.0), {900.0, 952.0}, {952.0, 952.0}}) {
    const auto images = ImagesInBand(held, lower_hz, upper_hz, 24.0 / 1048);
    ASSERT_EQ(images.size(), 1U);
    EXPECT_EQ(images[0].image_hz, 1048);
    EXPECT_EQ(images[0].folded_hz, 952);
    EXPECT_EQ(images[0].relative, 24.0 / 1048);
  }
  EXPECT_TRUE(ImagesInBand(held, 952.001, 1000, 24.0 / 1048).empty());
  EXPECT_TRUE(ImagesInBand(held, 900, 951.999, 24.0 / 1048).empty());
}

TEST(ImagesInBand, AreAboveHalfTheRateOfTheConverter) {
  // 3255.30 Hz is above half of 6500 Hz and below half of 6520 Hz
  const auto folded = ImagesInBand({0.33e-3, 225, 6500}, 3000, 4000, 0.05);
  ASSERT_EQ(folded.size(), 1U);
  EXPECT_REL(folded[0].folded_hz, 6500 - 3255.3030303, 1e-9, "ten digits");
  EXPECT_TRUE(ImagesInBand({0.33e-3, 225, 6520}, 3000, 4000, 0.05).empty());
}

TEST(UnfoldedRateHz, IsAtLeastWhatIsAsked) {
  // nothing has all of the tone's amplitude, so nothing is ever folded
  const HeldOutput held{.sampling_s = 0.33e-3, .frequency_hz = 225};
  for (const auto& [least_hz, rate_hz] : {std::pair(990.0, 1000.0),
                                          {1000.0, 1000.0},
                                          {1010.0, 2000.0},
                                          {2000.0, 2000.0},
                                          {4990.0, 5000.0},
                                          {5010.0, 10'000.0}}) {
    EXPECT_EQ(UnfoldedRateHz(held, 20, 500, 1, least_hz), rate_hz) << least_hz;
  }
}

}  // namespace
}  // namespace haptometer::acquire
