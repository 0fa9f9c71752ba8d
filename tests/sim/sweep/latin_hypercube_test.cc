#include "sim/sweep/latin_hypercube.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/residual.h"

namespace haptometer::sim {
namespace {

TEST(LatinHypercube, DealsEachPartOnceOnEveryAxis) {
  for (const std::uint64_t samples : {1U, 2U, 3U, 4U, 5U, 16U, 17U, 1000U, 4097U}) {
    for (const std::uint64_t seed : {0U, 1U, 7U}) {
      for (const std::uint32_t axis : {0U, 1U, 5U}) {
        const LatinHypercube cube{.samples = samples, .seed = seed};
        std::vector<int> times(samples);
        for (std::uint64_t point = 0; point < samples; ++point) {
          const std::uint64_t part = cube.PartOf(axis, point);
          ASSERT_LT(part, samples);
          ++times[part];
          const double place = cube.PlaceInPart(axis, point);
          EXPECT_GT(place, 0);
          EXPECT_LT(place, 1);
        }
        for (const int count : times) EXPECT_EQ(count, 1) << samples << " samples, seed " << seed;
      }
    }
  }
}

// chi squared with 4 degrees of freedom: above 30 once in 200 000 (seeds are fixed)
TEST(LatinHypercube, DealsEveryPartAlikeOverSeeds) {
  constexpr std::uint64_t kSamples = 5;
  constexpr int kSeeds = 5000;
  for (std::uint64_t point = 0; point < kSamples; ++point) {
    std::vector<double> times(kSamples);
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      ++times[LatinHypercube{.samples = kSamples, .seed = seed}.PartOf(0, point)];
    }
    double chi_squared = 0;
    for (const double count : times) {
      constexpr double kExpected = kSeeds / static_cast<double>(kSamples);
      chi_squared += (count - kExpected) * (count - kExpected) / kExpected;
    }
    EXPECT_LT(chi_squared, 30) << "point " << point;
  }
}

// Axes are dealt apart from each other: the correlation of 4096 pairs has a standard deviation of
// 1/64, and 4.5 of it are passed once in 150 000.
TEST(LatinHypercube, DealsAxesAndSeedsApart) {
  constexpr std::uint64_t kSamples = 4096;
  const LatinHypercube cube{.samples = kSamples, .seed = 3};
  const LatinHypercube other{.samples = kSamples, .seed = 4};
  double axes = 0;
  double seeds = 0;
  double places = 0;
  double square = 0;
  for (std::uint64_t point = 0; point < kSamples; ++point) {
    const auto centred = [](std::uint64_t part) {
      return static_cast<double>(part) - 0.5 * (kSamples - 1);
    };
    const double here = centred(cube.PartOf(0, point));
    axes += here * centred(cube.PartOf(1, point));
    seeds += here * centred(other.PartOf(0, point));
    places += (cube.PlaceInPart(0, point) - 0.5) * (cube.PlaceInPart(1, point) - 0.5) * 12;
    square += here * here;
  }
  EXPECT_LT(std::abs(axes / square), 4.5 / 64);
  EXPECT_LT(std::abs(seeds / square), 4.5 / 64);
  EXPECT_LT(std::abs(places / kSamples), 4.5 / 64);
}

// The promise of the header: a point is a function of seed, samples and its number, for ever; with
// other samples it is another. Recorded: a table begun today must be gone on with tomorrow.
TEST(LatinHypercube, StaysWhatItIs) {
  const LatinHypercube cube{.samples = 1000, .seed = 7};
  EXPECT_EQ(cube.PartOf(0, 0), 545);
  EXPECT_EQ(cube.PartOf(0, 999), 785);
  EXPECT_EQ(cube.PartOf(1, 0), 274);
  EXPECT_EQ(cube.PlaceInPart(0, 0) * (1 << 22), 3516809.5);
  int moved = 0;
  const LatinHypercube more{.samples = 1001, .seed = 7};
  for (std::uint64_t point = 0; point < 1000; ++point) {
    moved += cube.PartOf(0, point) != more.PartOf(0, point) ? 1 : 0;
  }
  EXPECT_GT(moved, 0);
}

}  // namespace
}  // namespace haptometer::sim
