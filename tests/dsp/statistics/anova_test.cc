#include "dsp/statistics/anova.h"

#include <gtest/gtest.h>

#include <vector>

#include "dsp/statistics/paired.h"
#include "tests/dsp/statistics/table_of.h"
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

}  // namespace
}  // namespace haptometer::dsp
