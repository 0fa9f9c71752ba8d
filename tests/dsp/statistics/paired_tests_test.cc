#include "dsp/statistics/paired_tests.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

TEST(ComparePairs, SaysWhatCannotBeTested) {
  EXPECT_FALSE(ComparePairs(std::vector{2.0}, std::vector{1.0}).standard_deviation);
  const OneSample alike = ComparePairs(std::vector{2.0, 3.0}, std::vector{1.0, 2.0});
  EXPECT_EQ(alike.mean, 1);
  EXPECT_FALSE(alike.test);
  EXPECT_FALSE(EffectOfPairs(std::vector{2.0, 3.0, 5.0}, std::vector{1.0, 2.0, 4.0}));
}

TEST(RatioOfPairs, IsGeometric) {
  const auto ratio = RatioOfPairs(std::vector{8.0, 2.0}, std::vector{1.0, 1.0});
  EXPECT_REL(ratio->ratio, 4.0, 1e-15, "sqrt(16)");
  EXPECT_FALSE(RatioOfPairs(std::vector{8.0, 0.0}, std::vector{1.0, 1.0}));
}

TEST(CompareMeans, IsUnboundedWhereTheDenominatorMayBeZero) {
  const std::vector<double> a{2, 3, 2.5};
  const auto unbounded = CompareMeans(a, std::vector{1.0, -1.0, 0.5});
  EXPECT_REL(unbounded->ratio, 15.0, 1e-14, "2.5 / (1/6)");
  EXPECT_FALSE(unbounded->interval);
  EXPECT_TRUE(CompareMeans(a, std::vector{1.0, 1.1, 0.9})->interval);
  EXPECT_FALSE(CompareMeans(a, std::vector{1.0, -1.0, 0.0}));
}

TEST(HedgesCorrection, IsExact) {
  // Gamma(7/2) = 15 sqrt(pi) / 8, Gamma(3) = 2
  EXPECT_REL(HedgesCorrection(7), 15 * std::sqrt(std::numbers::pi) / 16 / std::sqrt(3.5), 1e-15,
             "closed form: 0.888203");
  EXPECT_REL(HedgesCorrection(400), 1 - 3.0 / (4 * 400 - 1), 1e-6, "Hedges' approximation");
}

TEST(SignFlipP, CountsAllSigns) {
  // the sums of +-1 +-2 +-4 are the odd numbers from -7 to 7
  EXPECT_EQ(SignFlipP(std::vector{1.0, 2.0, 4.0}), 0.25);
  EXPECT_EQ(SignFlipP(std::vector{1.0, 2.0, -4.0}), 1);
  EXPECT_EQ(SignFlipP(std::vector<double>(8, 0.1)), 2.0 / 256);
  // ties in another rounding: |-7 - 9 + 9| and its like, in tenths
  EXPECT_EQ(SignFlipP(std::vector{-0.7, -0.9, 0.9}), 1);
  EXPECT_EQ(SignFlipP(std::vector{-0.9, -0.8, 0.2, 0.6}), 0.625);
  EXPECT_FALSE(SignFlipP(std::vector<double>(21, 1.0)));
  EXPECT_FALSE(SignFlipP({}));
}

TEST(HolmAdjusted, IsMonotoneAndInOrder) {
  // Holm 1979 with m = 3: 3 x 0.01, then 2 x 0.02, then max(0.04, 0.03)
  const auto adjusted = HolmAdjusted(std::vector{0.03, 0.01, 0.02});
  EXPECT_DOUBLE_EQ(adjusted[1], 0.03);
  EXPECT_DOUBLE_EQ(adjusted[2], 0.04);
  EXPECT_DOUBLE_EQ(adjusted[0], 0.04);
  EXPECT_EQ(HolmAdjusted(std::vector{0.9, 0.8})[0], 1);
  EXPECT_TRUE(HolmAdjusted({}).empty());
}

TEST(HolmOverTested, CountsOnlyWhatWasTested) {
  const auto adjusted = HolmOverTested(std::vector<std::optional<double>>{{}, 0.01, {}, 0.04});
  EXPECT_EQ(adjusted, (std::vector<std::optional<double>>{{}, 0.02, {}, 0.04})) << "two tests";
}

}  // namespace
}  // namespace haptometer::dsp
