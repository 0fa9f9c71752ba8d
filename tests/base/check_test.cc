#include "base/check.h"

#include <gtest/gtest.h>

namespace haptometer {
namespace {

// a file and line below the root of the sources, whatever folder they were built in
TEST(CheckDeathTest, NamesThePlaceWithoutThePathOfTheBuild) {
  const double rate_hz = -2;
  EXPECT_DEATH(HAPTOMETER_CHECK(rate_hz > 0, "rate_hz = {}", rate_hz),
               "^tests/base/check_test.cc:[0-9]+: check failed: rate_hz > 0 \\(rate_hz = -2\\)");
}

TEST(Check, PassesWhatHolds) { HAPTOMETER_CHECK(true, "{}", 1); }

}  // namespace
}  // namespace haptometer
