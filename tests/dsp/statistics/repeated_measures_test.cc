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

}  // namespace
}  // namespace haptometer::dsp
