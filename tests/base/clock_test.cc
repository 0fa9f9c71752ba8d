#include "base/clock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <time.h>

#include <chrono>
#include <cstdio>

namespace haptometer {
namespace {

TEST(Clock, SecondsAndNanosecondsConvertBothWays) {
  EXPECT_EQ(NsFromSeconds(1.5), 1'500'000'000);
  EXPECT_EQ(NsFromSeconds(-2e-9), -2);
  EXPECT_EQ(SecondsFromNs(250'000'000), 0.25);
}

TEST(Clock, SecondsAreRoundedToTheNearestNanosecond) {
  EXPECT_EQ(NsFromSeconds(1.4e-9), 1);
  EXPECT_EQ(NsFromSeconds(1.6e-9), 2);
  EXPECT_EQ(NsFromSeconds(-1.4e-9), -1);
  EXPECT_EQ(NsFromSeconds(-1.6e-9), -2);
  EXPECT_EQ(SecondsFromNs(1), 1e-9);
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

// milliseconds since 1970 by the C++ library
std::int64_t UnixMs() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::floor<std::chrono::milliseconds>(now).count();
}

TEST(UtcNow, IsTheTimeOfTheSystem) {
  const std::int64_t before = UnixMs();
  const std::string text = UtcNow();
  const std::int64_t after = UnixMs();
  tm utc{};
  int ms = 0;
  ASSERT_EQ(std::sscanf(text.c_str(), "%d-%d-%dT%d:%d:%d.%dZ", &utc.tm_year, &utc.tm_mon,
                        &utc.tm_mday, &utc.tm_hour, &utc.tm_min, &utc.tm_sec, &ms),
            7);
  utc.tm_year -= 1900;
  utc.tm_mon -= 1;
  const std::int64_t told = std::int64_t{timegm(&utc)} * 1000 + ms;
  EXPECT_LE(before, told);
  EXPECT_LE(told, after);
}

}  // namespace
}  // namespace haptometer
