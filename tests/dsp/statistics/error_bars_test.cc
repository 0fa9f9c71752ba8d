#include "dsp/statistics/error_bars.h"

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "dsp/statistics/paired.h"
#include "tests/dsp/statistics/table_of.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

TEST(MoreyHalfWidths, OfTwoConditionsAreThoseOfTheDifference) {
  // with k = 2 the corrected bar is the interval of the difference over sqrt(2)
  const CompleteTable table = TableOf(4, 2, {1, 3, 2, 3, 4, 9, 5, 6});
  const auto pair = ComparePairs(table.Condition(1), table.Condition(0));
  const double half = (pair.test->mean.upper - pair.test->mean.lower) / 2;
  for (const double bar : MoreyHalfWidths(table)) {
    EXPECT_REL(bar, half / std::numbers::sqrt2, 1e-14, "rounding");
  }
}

}  // namespace
}  // namespace haptometer::dsp
