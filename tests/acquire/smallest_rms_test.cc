// The smallest RMS that may be reported, against its equation and against noise from a generator.
#include "acquire/ability/smallest_rms.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/residual.h"

namespace haptometer::acquire {
namespace {

const NoiseInBand kIl030{.rms_m = 6e-6, .bandwidth_hz = 480, .record_s = 10, .noise_record_s = 10};

// worked by hand: B T = 4800; s = 4 * 4800 * 0.1^2 = 192, q = (1 + sqrt(385)) / 192 = 0.107403
TEST(SmallestRms, WorkedExample) {
  EXPECT_REL(SmallestRms(kIl030, 0.1), 6e-6 * std::sqrt(0.107403), 1e-5, "six digits");
  // s = 1.92, q = (1 + sqrt(4.84)) / 1.92 = 1.6666...
  EXPECT_REL(SmallestRms(kIl030, 0.01), 6e-6 * std::sqrt(3.2 / 1.92), 1e-14, "a few roundings");
}

TEST(SmallestRms, IsTheRootOfTheUncertainty) {
  for (const double relative : {0.001, 0.01, 0.1, 0.5}) {
    for (const double noise_record_s : {1.0, 10.0, 1000.0}) {
      NoiseInBand noise = kIl030;
      noise.noise_record_s = noise_record_s;
      EXPECT_REL(RelativeUncertainty(noise, SmallestRms(noise, relative)), relative, 1e-13,
                 "a few roundings");
    }
  }
}

// a tone in white noise, its power less that of other noise: B = half the rate, so B T = n / 2
TEST(SmallestRms, TheScatterIsThatOfSimulatedRecords) {
  constexpr int kSamples = 400;
  constexpr int kRecords = 4000;
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise;
  for (const double rms : {0.7, 1.0, 3.0}) {
    double sum = 0;
    double squares = 0;
    for (int record = 0; record < kRecords; ++record) {
      double power = 0;
      double noise_power = 0;
      for (int i = 0; i < kSamples; ++i) {
        const double tone =
            std::numbers::sqrt2 * rms * std::sin(2 * std::numbers::pi * 37 * i / kSamples + 0.3);
        power += std::pow(tone + noise(random), 2) / kSamples;
        noise_power += std::pow(noise(random), 2) / kSamples;
      }
      const double estimate = std::sqrt(std::max(power - noise_power, 0.0));
      sum += estimate;
      squares += estimate * estimate;
    }
    const double mean = sum / kRecords;
    const double scatter = std::sqrt(squares / kRecords - mean * mean) / mean;
    const NoiseInBand white{
        .rms_m = 1, .bandwidth_hz = 0.5, .record_s = kSamples, .noise_record_s = kSamples};
    // 4000 records know a scatter to 1.1 %; the root's bend adds the square of the scatter
    EXPECT_REL(scatter, RelativeUncertainty(white, rms), 0.04 + scatter * scatter,
               "three standard deviations of the simulation, and the bend of the root");
    EXPECT_REL(mean, rms, 0.01 + scatter * scatter, "subtracting the noise leaves no bias");
  }
}

}  // namespace
}  // namespace haptometer::acquire
