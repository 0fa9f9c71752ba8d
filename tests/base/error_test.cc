#include "base/error.h"

#include <gtest/gtest.h>

namespace haptometer {
namespace {

// a file and line below the root of the sources, whatever folder they were built in
TEST(CheckDeathTest, NamesThePlaceWithoutThePathOfTheBuild) {
  const double rate_hz = -2;
  EXPECT_DEATH(HAPTOMETER_CHECK(rate_hz > 0, "rate_hz = {}", rate_hz),
               "^tests/base/error_test.cc:[0-9]+: check failed: rate_hz > 0 \\(rate_hz = -2\\)");
}

TEST(Check, PassesWhatHolds) { HAPTOMETER_CHECK(true, "{}", 1); }

TEST(Error, TextJoinsWhereWhatAndRemedy) {
  EXPECT_EQ((Error{Cause::kFailed, "a.csv", "is empty", "record again"}).Text(),
            "a.csv: is empty; record again");
  EXPECT_EQ((Error{Cause::kFailed, "", "no answer", ""}).Text(), "no answer");
}

TEST(Error, CauseDecidesTheExitStatus) {
  EXPECT_EQ(ExitStatus(Failed("", "").error().cause), 1);
  EXPECT_EQ(ExitStatus(Usage("", "").error().cause), 2);
  EXPECT_EQ(ExitStatus(CannotAnswer("", "").error().cause), 3);
}

TEST(CheckDeathTest, PrintsTheExpressionAndTheValues) {
  const double rate_hz = -3;
  EXPECT_DEATH(HAPTOMETER_CHECK(rate_hz > 0, "rate_hz = {}", rate_hz),
               "check failed: rate_hz > 0 \\(rate_hz = -3\\)");
}

}  // namespace
}  // namespace haptometer
