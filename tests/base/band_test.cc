#include "base/band.h"

#include <gtest/gtest.h>

namespace haptometer {
namespace {

TEST(ObservedBand, IsThatOfTheCustomaryFactor) {
  EXPECT_DOUBLE_EQ(NeededRateHz(kDefaultUpperHz), 1280);
  EXPECT_DOUBLE_EQ(HighestObservableHz(1280), 500);
  EXPECT_TRUE(Observes(1280, 500));
  EXPECT_FALSE(Observes(1250, 500));
  EXPECT_TRUE(Observes(1250, 488));
}

// an interval of 781.25 us that a clock 100 ppm off measures is still that of 1280 readings/s
TEST(ObservedBand, AClocksErrorTakesNothingFromIt) {
  EXPECT_TRUE(Observes(1280 * (1 - 0.9e-4), 500));
  EXPECT_FALSE(Observes(1280 * (1 - 1.1e-4), 500));
}

}  // namespace
}  // namespace haptometer
