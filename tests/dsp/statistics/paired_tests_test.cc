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

// differences 1, 2, 3 of a = {1, 4, 7}, b = {0, 2, 4}: mean 2, deviations 1, 3 and 2
TEST(EffectOfPairs, IsOverEachOfTheThreeDeviations) {
  const auto effect = EffectOfPairs(std::vector{1.0, 4.0, 7.0}, std::vector{0.0, 2.0, 4.0});
  ASSERT_TRUE(effect);
  EXPECT_REL(effect->d_z, 2, 1e-14, "rounding");
  // J(2) = Gamma(1) / Gamma(1/2)
  EXPECT_REL(effect->hedges_g, 2 / std::sqrt(std::numbers::pi), 1e-14, "closed form");
  EXPECT_REL(effect->d_av, 2 / 2.5, 1e-14, "rounding");
  EXPECT_FALSE(EffectOfPairs(std::vector{1.0, 4.0}, std::vector{0.0, 2.0})) << "two pairs";
}

// of two pairs the quantile of one degree of freedom is tan(0.475 pi)
TEST(CompareMeans, OfTwoPairsIsFiellersQuadratic) {
  // means 4 and 200, variances 2 and 8, covariance 4: c = t^2 / 2
  const auto ratio = CompareMeans(std::vector{3.0, 5.0}, std::vector{198.0, 202.0});
  ASSERT_TRUE(ratio && ratio->interval);
  const double t = std::tan(0.475 * std::numbers::pi);
  const double c = t * t / 2;
  const double square = 200.0 * 200 - 8 * c;
  const double half = 4.0 * 200 - 4 * c;
  const double root = std::sqrt(half * half - square * (4.0 * 4 - 2 * c));
  EXPECT_REL(ratio->ratio, 0.02, 1e-15, "rounding");
  EXPECT_REL(ratio->interval->lower, (half - root) / square, 1e-12, "the quantile's rounding");
  EXPECT_REL(ratio->interval->upper, (half + root) / square, 1e-12, "the quantile's rounding");
  EXPECT_FALSE(CompareMeans(std::vector{3.0}, std::vector{198.0})) << "one pair";
}

// mean(b)^2 against t^2 var(b) / n, 2 pairs that differ by 2: var(b) = 2
TEST(CompareMeans, IsUnboundedFromTheMeanOnThatMayBeZero) {
  const double t = std::tan(0.475 * std::numbers::pi);
  for (const double share : {0.99, 1.01}) {
    const double mean = share * t;
    const auto ratio = CompareMeans(std::vector{1.0, 2.0}, std::vector{mean - 1, mean + 1});
    ASSERT_TRUE(ratio);
    EXPECT_EQ(ratio->interval.has_value(), share > 1) << share;
  }
}

TEST(SignFlipP, TakesTwentyDifferences) {
  EXPECT_EQ(SignFlipP(std::vector<double>(20, 1.0)), 2 / 0x1p20);
  EXPECT_EQ(SignFlipP(std::vector{1.0}), 1);
}

TEST(PairedTestsDeathTest, TakePairsAndTwoDegreesOfFreedom) {
  const std::vector<double> two{1, 2};
  const std::vector<double> three{1, 2, 4};
  const std::vector<double> none;
  EXPECT_DEATH(static_cast<void>(ComparePairs(two, three)), "check failed");
  EXPECT_DEATH(static_cast<void>(ComparePairs(none, none)), "check failed");
  EXPECT_DEATH(static_cast<void>(RatioOfPairs(two, three)), "check failed");
  EXPECT_DEATH(static_cast<void>(RatioOfPairs(none, none)), "check failed");
  EXPECT_DEATH(static_cast<void>(CompareMeans(two, three)), "check failed");
  EXPECT_DEATH(static_cast<void>(HedgesCorrection(1)), "check failed");
}

// a = 1, 4, 7 and b = 9, 10, 14: variances 9 and 7, covariance 7.5, and the quantile of two degrees
// of freedom is 0.95 sqrt(2 / (1 - 0.95^2))
TEST(CompareMeans, OfThreePairsIsFiellersQuadratic) {
  const auto ratio = CompareMeans(std::vector{1.0, 4.0, 7.0}, std::vector{9.0, 10.0, 14.0});
  ASSERT_TRUE(ratio && ratio->interval);
  const double c = 0.95 * 0.95 * 2 / (1 - 0.95 * 0.95) / 3;
  const double square = 11.0 * 11 - c * 7;
  const double half = 4.0 * 11 - c * 7.5;
  const double root = std::sqrt(half * half - square * (4.0 * 4 - c * 9));
  EXPECT_REL(ratio->interval->lower, (half - root) / square, 1e-12, "the quantile's rounding");
  EXPECT_REL(ratio->interval->upper, (half + root) / square, 1e-12, "the quantile's rounding");
}

// differences -1, 2, 8: mean 3, deviation sqrt(21); of three pairs the noncentrality is sqrt(3)
// times the effect
TEST(EffectOfPairs, IntervalIsThatOfTheNoncentrality) {
  const auto effect = EffectOfPairs(std::vector{1.0, 4.0, 7.0}, std::vector{2.0, 2.0, -1.0});
  ASSERT_TRUE(effect && effect->interval);
  EXPECT_REL(effect->d_z, 3 / std::sqrt(21.0), 1e-14, "rounding");
  EXPECT_REL(effect->d_av, 3 / (0.5 * (3 + std::sqrt(3.0))), 1e-14, "rounding");
  const auto delta = NoncentralityInterval(3 / std::sqrt(21.0 / 3), 2);
  ASSERT_TRUE(delta);
  EXPECT_REL(effect->interval->lower, delta->lower / std::sqrt(3.0), 1e-12, "rounding of t");
  EXPECT_REL(effect->interval->upper, delta->upper / std::sqrt(3.0), 1e-12, "rounding of t");
}

// sums of 1 + e and of 1 - e count as equal where 2 e is below 1e-12 of 1 + e
TEST(SignFlipP, SumsWithin1eMinus12OfAllAreEqual) {
  EXPECT_EQ(SignFlipP(std::vector{1.0, 0.4975e-12}), 1);
  EXPECT_EQ(SignFlipP(std::vector{1.0, 0.5025e-12}), 0.5);
}

}  // namespace
}  // namespace haptometer::dsp
