#include "base/median.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <limits>
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

}  // namespace
}  // namespace haptometer
