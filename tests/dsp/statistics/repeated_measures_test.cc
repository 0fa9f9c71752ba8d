#include "dsp/statistics/repeated_measures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "dsp/statistics/paired_tests.h"
#include "tests/dsp/signals.h"
#include "tests/dsp/statistics/table_of.h"
#include "tests/repetitions.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

TEST(RepeatedMeasuresAnova, OfTwoConditionsIsThePairedT) {
  const CompleteTable table = TableOf(4, 2, {1, 3, 2, 3, 4, 9, 5, 6});
  const auto anova = AnalyzeRepeatedMeasures(table);
  const auto pair = ComparePairs(table.Condition(1), table.Condition(0));
  EXPECT_REL(anova->f, pair.test->t * pair.test->t, 1e-14, "rounding");
  EXPECT_REL(anova->p, pair.test->p, 1e-13, "rounding");
  EXPECT_EQ(anova->greenhouse_geisser, 1);
  EXPECT_EQ(anova->df_error, 3);
  EXPECT_FALSE(AnalyzeRepeatedMeasures(TableOf(2, 2, {0.1, 0.2, 0.3, 0.4})));
}

TEST(MoreyHalfWidths, OfTwoConditionsAreThoseOfTheDifference) {
  // with k = 2 the corrected bar is the interval of the difference over sqrt(2)
  const CompleteTable table = TableOf(4, 2, {1, 3, 2, 3, 4, 9, 5, 6});
  const auto pair = ComparePairs(table.Condition(1), table.Condition(0));
  const double half = (pair.test->mean.upper - pair.test->mean.lower) / 2;
  for (const double bar : MoreyHalfWidths(table)) {
    EXPECT_REL(bar, half / std::numbers::sqrt2, 1e-14, "rounding");
  }
}

TEST(VariationOfLogs, IsThatOfALognormalValue) {
  // variance / mean^2 = exp(s^2) - 1
  EXPECT_REL(VariationOfLogs(1), std::sqrt(std::exp(1.0) - 1), 1e-15, "rounding");
  EXPECT_REL(VariationOfLogs(1e-9), 1e-9, 1e-15, "s itself where it is small");
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

// subjects 10, 20 and 30 and deviations whose rows add up to 0; the deviations of the columns are
// 1, sqrt(1/3) and sqrt(4/3), and the quantile of two degrees of freedom is 0.95 sqrt(2 / (1 -
// 0.95^2))
TEST(MoreyHalfWidths, OfThreeConditionsAreTheClosedForm) {
  const CompleteTable table = TableOf(3, 3, {10, 11, 9, 21, 20, 19, 29, 30, 31});
  const double t = 0.95 * std::sqrt(2 / (1 - 0.95 * 0.95));
  const double factor = t / std::sqrt(3.0) * std::sqrt(1.5);
  const auto widths = MoreyHalfWidths(table);
  ASSERT_EQ(widths.size(), 3U);
  EXPECT_REL(widths[0], factor, 1e-13, "rounding of the quantile");
  EXPECT_REL(widths[1], factor * std::sqrt(1.0 / 3), 1e-13, "rounding of the quantile");
  EXPECT_REL(widths[2], factor * std::sqrt(4.0 / 3), 1e-13, "rounding of the quantile");
}

// Columns 0, 1, 2 about each subject, and a residual of -1, 2, -1 in the first and 1, -2, 1 in the
// second: 2 (0 + 1 + 1) between conditions, 12 left. The residual lies along one direction, so
// epsilon is 1 / (k - 1).
TEST(RepeatedMeasuresAnova, DividesTheSquaresAsTheClosedFormSays) {
  const CompleteTable table = TableOf(2, 3, {-1, 3, 1, 101, 99, 103});
  const auto anova = AnalyzeRepeatedMeasures(table);
  ASSERT_TRUE(anova);
  EXPECT_EQ(anova->df_conditions, 2);
  EXPECT_EQ(anova->df_error, 2);
  EXPECT_REL(anova->f, 4.0 / 12, 1e-12, "rounding of values of 100");
  EXPECT_REL(anova->partial_eta_squared, 4.0 / 16, 1e-12, "rounding of values of 100");
  EXPECT_REL(anova->greenhouse_geisser, 0.5, 1e-12, "rounding of values of 100");
  // F(2, 2): P(F >= f) = 1 / (1 + f); half of both degrees of freedom: F(1, 1)
  EXPECT_REL(anova->p, 1 / (1 + 4.0 / 12), 1e-12, "closed form");
  EXPECT_REL(anova->p_greenhouse_geisser, 1 - 2 / std::numbers::pi * std::atan(std::sqrt(4.0 / 12)),
             1e-12, "closed form");
}

// two cells of two repeats: F = 7.2 on 1 and 2 degrees of freedom, whose quantiles have closed
// forms: sqrt(f / (f + 2)) = 0.975, and of F(2, 1) 1 - 1 / sqrt(1 + 2 f) = 0.975
TEST(AssessRepeats, HasTheIntervalOfMcGrawAndWong) {
  const auto reliability = AssessRepeats(std::vector<std::vector<double>>{{0, 2}, {5, 9}});
  ASSERT_TRUE(reliability);
  const auto icc = [](double f) { return (f - 1) / (f + 1); };
  const double lower = 2 * 0.975 * 0.975 / (1 - 0.975 * 0.975);
  const double upper = 0.5 * (1 / (0.025 * 0.025) - 1);
  EXPECT_REL(reliability->icc, icc(7.2), 1e-14, "rounding");
  EXPECT_REL(reliability->within_sd, std::sqrt(5.0), 1e-14, "rounding");
  EXPECT_REL(reliability->interval.lower, icc(7.2 / lower), 1e-11, "rounding of quantiles");
  EXPECT_REL(reliability->interval.upper, icc(7.2 * upper), 1e-11, "rounding of quantiles");
}

TEST(CompleteTableDeathTest, EndsAtItsLastSubjectAndCondition) {
  CompleteTable table = TableOf(2, 3, {1, 2, 3, 4, 5, 6});
  const CompleteTable& fixed = table;
  EXPECT_EQ(fixed.At(1, 2), 6);
  EXPECT_DEATH(static_cast<void>(table.At(2, 0)), "check failed");
  EXPECT_DEATH(static_cast<void>(table.At(0, 3)), "check failed");
  EXPECT_DEATH(static_cast<void>(fixed.At(2, 0)), "check failed");
  EXPECT_DEATH(static_cast<void>(fixed.At(0, 3)), "check failed");
  EXPECT_DEATH(static_cast<void>(table.Subject(2)), "check failed");
  EXPECT_DEATH(static_cast<void>(MoreyHalfWidths(TableOf(1, 3, {1, 2, 3}))), "check failed");
  EXPECT_DEATH(static_cast<void>(MoreyHalfWidths(TableOf(3, 1, {1, 2, 3}))), "check failed");
}

// third parts of 1e9 are rounded to 6e-8: residuals of that size are none
TEST(RepeatedMeasuresAnova, ResidualsOfRoundingAreNone) {
  std::vector<double> values;
  for (const double subject : {0.0, 1.0, 5.0}) {
    for (const double condition : {1.0, 2.0, 7.0})
      values.push_back((subject + condition) * 1e9 / 3);
  }
  EXPECT_FALSE(AnalyzeRepeatedMeasures(TableOf(3, 3, values)));
  values[4] += 1e-3;
  EXPECT_TRUE(AnalyzeRepeatedMeasures(TableOf(3, 3, values)));
}

TEST(AssessRepeats, OfOneSubjectOrOneRepeatIsNothing) {
  EXPECT_FALSE(AssessRepeats({}));
  EXPECT_FALSE(AssessRepeats(std::vector<std::vector<double>>{{1, 2}}));
  EXPECT_FALSE(AssessRepeats(std::vector<std::vector<double>>{{1}, {2}}));
}

}  // namespace
}  // namespace haptometer::dsp
