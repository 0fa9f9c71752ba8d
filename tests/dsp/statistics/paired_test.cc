#include "dsp/statistics/paired.h"

#include <gtest/gtest.h>

#include <vector>

#include "dsp/statistics/effect_size.h"
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

}  // namespace
}  // namespace haptometer::dsp
