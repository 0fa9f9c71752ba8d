#include "dsp/statistics/sign_flip.h"

#include <gtest/gtest.h>

#include <vector>

namespace haptometer::dsp {
namespace {

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

}  // namespace
}  // namespace haptometer::dsp
