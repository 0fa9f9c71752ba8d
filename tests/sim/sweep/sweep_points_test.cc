#include "sim/sweep/sweep_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "tests/residual.h"

namespace haptometer::sim {
namespace {

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
