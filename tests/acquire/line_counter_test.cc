// Lines lost by the numbers that the others carry.
#include "acquire/sensor/line_counter.h"

#include <gtest/gtest.h>

#include <random>

namespace haptometer::acquire {
namespace {

TEST(LineCounter, CountsWhatIsMissing) {
  LineCounter counter(1000);
  EXPECT_EQ(counter.LostBefore(997), 0);  // nothing is known of what came before
  EXPECT_EQ(counter.LostBefore(998), 0);
  EXPECT_EQ(counter.LostBefore(2), 3);  // 999, 0, 1
  EXPECT_EQ(counter.LostBefore(3), 0);
  EXPECT_EQ(counter.LostBefore(2), 998);
  EXPECT_EQ(counter.LostBefore(2), 999);  // a sensor sends no number twice
}

TEST(LineCounter, DamagedLinesWereThere) {
  LineCounter counter(100);
  counter.CountDamaged();
  EXPECT_EQ(counter.LostBefore(5), 0);
  counter.CountDamaged();
  EXPECT_EQ(counter.LostBefore(7), 0);
  counter.CountDamaged();
  EXPECT_EQ(counter.LostBefore(10), 1);
  counter.CountDamaged();
  counter.CountDamaged();
  EXPECT_EQ(counter.LostBefore(11), 0);  // noise that looked like lines
}

TEST(LineCounter, ALineWithoutACounterLosesNothing) {
  LineCounter counter(1);
  EXPECT_EQ(counter.LostBefore(0), 0);
  EXPECT_EQ(counter.LostBefore(0), 0);
}

// every line that was sent either came or is counted, as long as less than a turn is lost at once
TEST(LineCounter, AccountsForEveryLine) {
  std::mt19937 random(1);
  for (const std::int32_t turn : {10, 100, 1000}) {
    LineCounter counter(turn);
    std::int64_t sent = 0;
    std::int64_t came = 0;
    std::int64_t lost = 0;
    const std::int64_t first = 7;
    for (; came < 10'000; ++came) {
      if (came > 0) sent += 1 + static_cast<std::int64_t>(random() % static_cast<unsigned>(turn));
      lost += counter.LostBefore(static_cast<std::int32_t>((first + sent) % turn));
    }
    EXPECT_EQ(came + lost, sent + 1);
  }
}

}  // namespace
}  // namespace haptometer::acquire
