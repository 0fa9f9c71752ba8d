#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "dsp/statistics/anova.h"
#include "dsp/statistics/distributions.h"
#include "dsp/statistics/effect_size.h"
#include "dsp/statistics/error_bars.h"
#include "dsp/statistics/multiple.h"
#include "dsp/statistics/paired.h"
#include "dsp/statistics/permutation.h"
#include "dsp/statistics/regression.h"
#include "dsp/statistics/reliability.h"
#include "dsp/statistics/robust.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

TEST(Distributions, AreThoseOfTheirClosedForms) {
  // one degree of freedom: Cauchy; two: t / sqrt(2 + t^2)
  EXPECT_REL(StudentTwoSidedP(3, 1), 1 - 2 * std::atan(3.0) / std::numbers::pi, 1e-15, "rounding");
  EXPECT_REL(StudentTwoSidedP(-3, 2), 1 - 3 / std::sqrt(11.0), 1e-14, "cancels a digit");
  EXPECT_REL(StudentTwoSidedP(1e6, 3), 4 * std::sqrt(3.0) / std::numbers::pi * 1e-18, 1e-11,
             "leading term of the tail: 1.8/t^2 is left out");
  EXPECT_EQ(StudentTwoSidedP(std::numeric_limits<double>::infinity(), 3), 0);
  EXPECT_REL(StudentCritical(7), 2.364624251592784, 1e-14, "printed to 16 digits in R");
  EXPECT_REL(FisherUpperP(9, 1, 5), StudentTwoSidedP(3, 5), 1e-14, "F(1, n) is t^2");
  EXPECT_REL(ChiSquareQuantile(0.5, 2), 2 * std::numbers::ln2, 1e-15, "exponential");
}

TEST(NoncentralityInterval, MirrorsAndIsCentralAtZero) {
  const auto at_zero = NoncentralityInterval(0, 7);
  // T(df, delta) <= 0 is Z + delta <= 0
  EXPECT_REL(at_zero->upper, 1.959963984540054, 1e-12, "normal quantile");
  EXPECT_REL(at_zero->lower, -at_zero->upper, 1e-12, "symmetry");
  const auto right = NoncentralityInterval(6.5, 7);
  const auto left = NoncentralityInterval(-6.5, 7);
  EXPECT_EQ(right->lower, -left->upper);
  EXPECT_EQ(right->upper, -left->lower);
  EXPECT_TRUE(NoncentralityInterval(100, 7).has_value());
  EXPECT_TRUE(NoncentralityInterval(900, 7).has_value());
  EXPECT_FALSE(NoncentralityInterval(1e4, 7).has_value());
  EXPECT_FALSE(NoncentralityInterval(std::numeric_limits<double>::quiet_NaN(), 7).has_value());
}

TEST(HedgesCorrection, IsExact) {
  // Gamma(7/2) = 15 sqrt(pi) / 8, Gamma(3) = 2
  EXPECT_REL(HedgesCorrection(7), 15 * std::sqrt(std::numbers::pi) / 16 / std::sqrt(3.5), 1e-15,
             "closed form: 0.888203");
  EXPECT_REL(HedgesCorrection(400), 1 - 3.0 / (4 * 400 - 1), 1e-6, "Hedges' approximation");
}

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

CompleteTable Table(std::size_t subjects, std::size_t conditions,
                    const std::vector<double>& values) {
  CompleteTable table(subjects, conditions);
  for (std::size_t i = 0; i < values.size(); ++i) {
    table.At(i / conditions, i % conditions) = values[i];
  }
  return table;
}

TEST(RepeatedMeasuresAnova, OfTwoConditionsIsThePairedT) {
  const CompleteTable table = Table(4, 2, {1, 3, 2, 3, 4, 9, 5, 6});
  const auto anova = AnalyzeRepeatedMeasures(table);
  const auto pair = ComparePairs(table.Condition(1), table.Condition(0));
  EXPECT_REL(anova->f, pair.test->t * pair.test->t, 1e-14, "rounding");
  EXPECT_REL(anova->p, pair.test->p, 1e-13, "rounding");
  EXPECT_EQ(anova->greenhouse_geisser, 1);
  EXPECT_EQ(anova->df_error, 3);
  EXPECT_FALSE(AnalyzeRepeatedMeasures(Table(2, 2, {0.1, 0.2, 0.3, 0.4})));
}

TEST(MoreyHalfWidths, OfTwoConditionsAreThoseOfTheDifference) {
  // with k = 2 the corrected bar is the interval of the difference over sqrt(2)
  const CompleteTable table = Table(4, 2, {1, 3, 2, 3, 4, 9, 5, 6});
  const auto pair = ComparePairs(table.Condition(1), table.Condition(0));
  const double half = (pair.test->mean.upper - pair.test->mean.lower) / 2;
  for (const double bar : MoreyHalfWidths(table)) {
    EXPECT_REL(bar, half / std::numbers::sqrt2, 1e-14, "rounding");
  }
}

TEST(AssessRepeats, IsThatOfShroutAndFleiss) {
  // P. E. Shrout and J. L. Fleiss, Psychological Bulletin 86(2), 1979, table 2: ICC(1,1) = .17,
  // MS between 11.24, MS within 6.26
  const std::vector<std::vector<double>> cells{{9, 2, 5, 8}, {6, 1, 3, 2},  {8, 4, 6, 8},
                                               {7, 1, 2, 6}, {10, 5, 6, 9}, {6, 2, 4, 7}};
  const auto reliability = AssessRepeats(cells);
  EXPECT_ABS(reliability->icc, 0.166, 5e-4, "printed digits");
  EXPECT_ABS(reliability->within_sd * reliability->within_sd, 6.26, 0.01, "printed digits");
  EXPECT_LT(reliability->interval.lower, 0);
  EXPECT_GT(reliability->interval.upper, 0.6);
  EXPECT_FALSE(AssessRepeats(std::vector<std::vector<double>>{{1, 2}, {1, 2, 3}}));
  EXPECT_FALSE(AssessRepeats(std::vector<std::vector<double>>{{1, 1}, {2, 2}}));
}

TEST(FitLine, IsThatOfAnscombe) {
  // his first set (The American Statistician 27(1), 1973): 3.0 + 0.5 x, R^2 = 0.67,
  // standard error of the slope 0.118
  const std::vector<double> x{10, 8, 13, 9, 11, 14, 6, 4, 12, 7, 5};
  const std::vector<double> y{8.04, 6.95, 7.58, 8.81, 8.33, 9.96, 7.24, 4.26, 10.84, 4.82, 5.68};
  const auto line = FitLine(x, y);
  EXPECT_ABS(line->slope, 0.5, 2e-4, "printed digits");
  EXPECT_ABS(line->intercept, 3.0, 2e-3, "printed digits");
  EXPECT_ABS(line->r_squared, 0.667, 5e-4, "printed digits");
  const double error = (line->slope_interval.upper - line->slope) / StudentCritical(9);
  EXPECT_ABS(error, 0.118, 5e-4, "printed digits");
  EXPECT_FALSE(FitLine(std::vector{1.0, 1.0, 1.0}, std::vector{1.0, 2.0, 3.0}));
  EXPECT_FALSE(FitLine(std::vector{1.0, 2.0}, std::vector{1.0, 2.0}));
  EXPECT_EQ(FitLine(std::vector{1.0, 2.0, 3.0}, std::vector{2.0, 4.0, 6.0})->r_squared, 1);
}

TEST(MedianPolish, TakesOutEffectsAndLeavesTheOutlier) {
  CompleteTable table(5, 3);
  for (std::size_t s = 0; s < 5; ++s) {
    for (std::size_t c = 0; c < 3; ++c) table.At(s, c) = static_cast<double>(s * s + 10 * c);
  }
  table.At(2, 1) += 7;
  const CompleteTable left = MedianPolish(table);
  for (std::size_t s = 0; s < 5; ++s) {
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_ABS(left.At(s, c), s == 2 && c == 1 ? 7.0 : 0.0, 1e-12, "medians of exact sums");
    }
  }
}

TEST(RobustWithinDeviation, IsUnmovedByOneCell) {
  // two repeats d apart: sd = d / sqrt(2), over the median 0.6745 of |Z|
  std::vector<std::vector<double>> cells{{0, 1}, {5, 6}, {2, 3}};
  const double expected = std::numbers::sqrt2 / 2 / 0.674489750196082;
  EXPECT_REL(RobustWithinDeviation(cells).value(), expected, 1e-13, "normal quantile");
  cells.push_back({0, 100});
  cells.push_back({4});
  EXPECT_REL(RobustWithinDeviation(cells).value(), expected, 1e-13, "normal quantile");
  EXPECT_FALSE(RobustWithinDeviation(std::vector<std::vector<double>>{{1}}));
  EXPECT_FALSE(RobustWithinDeviation(std::vector<std::vector<double>>{{1, 1}}));
}

}  // namespace
}  // namespace haptometer::dsp
