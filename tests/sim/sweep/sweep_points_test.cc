#include "sim/sweep/sweep_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "tests/residual.h"

namespace haptometer::sim {
namespace {

using Words = std::array<std::uint32_t, 4>;

// the known answers of philox4x32-10 in Random123 1.x, tests/kat_vectors (Salmon et al.)
TEST(CounterRandom, GivesThePublishedAnswers) {
  constexpr std::uint32_t kAll = 0xffffffff;
  EXPECT_EQ(CounterRandom({0, 0, 0, 0}, 0),
            (Words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(CounterRandom({kAll, kAll, kAll, kAll}, 0xffffffffffffffff),
            (Words{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  // digits of pi; the key's first word is its lower half
  EXPECT_EQ(CounterRandom({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, 0x299f31d0a4093822),
            (Words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

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

// the header's permutation in Python: 1, 1, 1, 2, 2, 2 and 3 bits in each half, by what holds all
TEST(LatinHypercube, PermutesTheFewestBitsThatHoldAllPoints) {
  const std::vector<std::vector<std::uint64_t>> known = {
      {0},
      {1, 0},
      {1, 0, 3, 2},
      {1, 3, 4, 2, 0},
      {7, 3, 4, 2, 0, 6, 5, 1},
      {12, 11, 4, 2, 0, 6, 5, 8, 1, 13, 14, 10, 7, 15, 9, 3},
      {1, 0, 14, 7, 12, 11, 6, 15, 10, 9, 8, 3, 13, 16, 5, 2, 4}};
  for (const std::vector<std::uint64_t>& parts : known) {
    const LatinHypercube cube{.samples = parts.size(), .seed = 7};
    for (std::size_t point = 0; point < parts.size(); ++point) {
      EXPECT_EQ(cube.PartOf(2, point), parts[point]) << parts.size() << ' ' << point;
    }
  }
}

SweepAxis Range(std::string key, const SweepRange& range) { return {std::move(key), range}; }

std::vector<std::string> TextsAt(const SweepPoints& points, std::uint64_t point) {
  std::vector<std::string> texts;
  for (const SweepValue& value : points.At(point)) texts.push_back(value.text);
  return texts;
}

TEST(SweepPoints, RunThroughAGridLastAxisFastest) {
  const SweepPoints points({Range("a", {.begin = 100, .end = 400, .count = 301}),
                            {"b", std::vector{NumberValue(600), TextValue("soft")}}});
  EXPECT_EQ(points.size(), 602U);
  EXPECT_EQ(TextsAt(points, 0), (std::vector<std::string>{"100", "600"}));
  EXPECT_EQ(TextsAt(points, 1), (std::vector<std::string>{"100", "soft"}));
  EXPECT_EQ(TextsAt(points, 2), (std::vector<std::string>{"101", "600"}));
  EXPECT_EQ(TextsAt(points, 601), (std::vector<std::string>{"400", "soft"}));
  EXPECT_EQ(points.At(1)[1].literal, "\"soft\"");
}

// whole steps between whole ends are whole: their products with the count are exact
TEST(SweepPoints, GiveRoundNumbersTheirDigits) {
  const SweepAxis whole = Range("a", {.begin = 100, .end = 400, .count = 301});
  for (std::size_t k = 0; k < 301; ++k) EXPECT_EQ(ValueOf(whole, k).text, std::to_string(100 + k));
  const SweepRange down{.begin = 0.3, .end = -0.1, .count = 5};
  EXPECT_EQ(ValueOf(Range("a", down), 0).text, "0.3");
  EXPECT_EQ(ValueOf(Range("a", down), 4).text, "-0.1");
  EXPECT_EQ(NumberValue(-0.0).text, "0");
}

TEST(SweepPoints, EndWhereTheRangeEnds) {
  for (const double end : {0.1, 0.3, 0.7, 1.1, 225.3}) {
    const SweepRange range{.begin = 0, .end = end, .count = 4};
    EXPECT_EQ(ValueAt(range, 3, 3), end) << "the same double";
  }
}

TEST(SweepPoints, StepEvenlyInTheLogarithm) {
  const SweepRange range{.begin = 3, .end = 3e5, .spacing = Spacing::kLogarithmic, .count = 6};
  for (int k = 0; k < 6; ++k) {
    EXPECT_REL(ValueAt(range, k, 5), 3 * std::pow(10, k), 1.2e-16, "one rounding");
  }
  EXPECT_EQ(ValueAt(range, 5, 5), 3e5);
  EXPECT_EQ(ValueAt(range, 0, 5), 3);
}

TEST(SweepPoints, SampleEveryStratumOfEachKeyOnce) {
  constexpr std::uint64_t kSamples = 1000;
  const SweepRange hertz{.begin = 100, .end = 400};
  const SweepRange mass{.begin = 1e-4, .end = 1e-1, .spacing = Spacing::kLogarithmic};
  const SweepPoints points({Range("a", hertz),
                            Range("b", mass),
                            {"c", std::vector{TextValue("x"), TextValue("y"), TextValue("z")}}},
                           LatinHypercube{.samples = kSamples, .seed = 5});
  EXPECT_EQ(points.size(), kSamples);
  std::set<int> strata[2];
  std::multiset<std::string> listed;
  for (std::uint64_t point = 0; point < kSamples; ++point) {
    const auto values = points.At(point);
    const double share = (std::stod(values[0].text) - 100) / 300;
    const double decades = (std::log10(std::stod(values[1].text)) + 4) / 3;
    strata[0].insert(static_cast<int>(std::floor(share * kSamples)));
    strata[1].insert(static_cast<int>(std::floor(decades * kSamples)));
    listed.insert(values[2].text);
  }
  EXPECT_EQ(strata[0].size(), kSamples);
  EXPECT_EQ(*strata[0].begin(), 0);
  EXPECT_EQ(*strata[0].rbegin(), 999);
  EXPECT_EQ(strata[1].size(), kSamples);
  EXPECT_EQ(listed.count("x"), 334U);  // parts 0 to 333
  EXPECT_EQ(listed.count("y"), 333U);
  EXPECT_EQ(listed.count("z"), 333U);
}

// a further key leaves the values of those before it
TEST(SweepPoints, SampleAKeyByItsPlace) {
  const LatinHypercube sampling{.samples = 50, .seed = 2};
  const SweepAxis a = Range("a", {.begin = 0, .end = 1});
  const SweepPoints one({a}, sampling);
  const SweepPoints two({a, Range("b", {.begin = 5, .end = 7})}, sampling);
  for (std::uint64_t point = 0; point < 50; ++point) {
    EXPECT_EQ(TextsAt(one, point)[0], TextsAt(two, point)[0]);
  }
}

TEST(SweepPoints, CountMoreThanFitAsTheLargest) {
  const SweepAxis big = Range("a", {.begin = 0, .end = 1, .count = 1'000'000'000});
  EXPECT_EQ(SweepPoints({big, big}).size(), 1'000'000'000'000'000'000U);
  EXPECT_EQ(SweepPoints({big, big, big}).size(), std::numeric_limits<std::uint64_t>::max());
}

TEST(SweepAxis, IsSaidAsTheCommandLineTakesIt) {
  EXPECT_EQ(WordOf(Range("a", {.begin = 100, .end = 400, .count = 301})), "100:400:301");
  EXPECT_EQ(WordOf(Range("a", {.begin = 1e-3, .end = 2, .spacing = Spacing::kLogarithmic})),
            "log:0.001:2");
  EXPECT_EQ(WordOf({"a", std::vector{NumberValue(0.5), PlainValue("true"), TextValue("x")}}),
            "0.5,true,x");
}

}  // namespace
}  // namespace haptometer::sim
