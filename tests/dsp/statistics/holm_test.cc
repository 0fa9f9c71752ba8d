#include "dsp/statistics/holm.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

namespace haptometer::dsp {
namespace {

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
