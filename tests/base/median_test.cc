#include "base/median.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

namespace haptometer {
namespace {

TEST(Median, IsTheMiddleValueOrTheMeanOfTheMiddleTwo) {
  EXPECT_EQ(Median({7}), 7);
  EXPECT_EQ(Median({9, 1, 4}), 4);
  EXPECT_EQ(Median({9, 1, 4, 7}), 5.5);
  EXPECT_EQ(Median({2, 2, 2, 9, 9}), 2);
  constexpr double kMost = std::numeric_limits<double>::max();
  EXPECT_EQ(Median({kMost, kMost}), kMost) << "the sum of both overflows";
}

TEST(UpperMedian, IsAValueThatOccurs) {
  EXPECT_EQ(UpperMedian(std::vector<double>{}), 0);
  EXPECT_EQ(UpperMedian(std::vector<double>{9, 1, 4}), 4);
  EXPECT_EQ(UpperMedian(std::vector<double>{9, 1, 4, 7}), 7);
  EXPECT_EQ(UpperMedian(std::array<std::int64_t, 2>{-3, -8}), -3);
}

// half of a normal distribution lies within one median of |x - mean|
TEST(DeviationsPerMedian, IsThatOfTheNormalDistribution) {
  const double share = std::erf(1 / (kDeviationsPerMedian * std::numbers::sqrt2));
  EXPECT_NEAR(share, 0.5, 5e-16) << "rounding of the argument and of erf";
}

}  // namespace
}  // namespace haptometer
