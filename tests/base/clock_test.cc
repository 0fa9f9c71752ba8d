#include "base/clock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace haptometer {
namespace {

TEST(Clock, SecondsAndNanosecondsConvertBothWays) {
  EXPECT_EQ(NsFromSeconds(1.5), 1'500'000'000);
  EXPECT_EQ(NsFromSeconds(-2e-9), -2);
  EXPECT_EQ(SecondsFromNs(250'000'000), 0.25);
}

TEST(SystemClock, SleepsUntilTheTimeAndNeverRunsBack) {
  SystemClock clock;
  const MonotonicNs start = clock.Now();
  clock.SleepUntil(start + 2'000'000);
  EXPECT_GE(clock.Now(), start + 2'000'000);
  clock.SleepUntil(start);  // the past: returns at once
  EXPECT_GE(clock.Now(), start + 2'000'000);
}

TEST(ManualClock, MovesOnlyWhenTold) {
  ManualClock clock;
  clock.SleepUntil(5);
  EXPECT_EQ(clock.Now(), 5);
  clock.SleepUntil(3);
  EXPECT_EQ(clock.Now(), 5);
  clock.Advance(7);
  EXPECT_EQ(clock.Now(), 12);
}

TEST(UtcNow, IsIso8601WithMilliseconds) {
  EXPECT_THAT(UtcNow(), ::testing::MatchesRegex("20[0-9][0-9]-[01][0-9]-[0-3][0-9]T[0-2][0-9]:[0-5]"
                                                "[0-9]:[0-6][0-9]\\.[0-9][0-9][0-9]Z"));
}

}  // namespace
}  // namespace haptometer
