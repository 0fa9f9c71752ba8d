#include "acquire/sensor/response_deadline.h"

#include <gtest/gtest.h>

namespace haptometer::acquire {
namespace {

constexpr MonotonicNs kMs = 1'000'000;

TEST(ResponseDeadline, IsTheMakersSecondUntilTheUnitIsKnown) {
  ResponseDeadline deadline;
  EXPECT_EQ(deadline.WaitNs(), kNsPerS);
  for (int i = 0; i < 63; ++i) deadline.Note(8 * kMs);
  EXPECT_EQ(deadline.WaitNs(), kNsPerS);
  deadline.Note(8 * kMs);
  EXPECT_EQ(deadline.WaitNs(), 50 * kMs);
  deadline.Note(30 * kMs);
  EXPECT_EQ(deadline.WaitNs(), 120 * kMs);
  deadline.Note(900 * kMs);
  EXPECT_EQ(deadline.WaitNs(), kNsPerS);
  for (int i = 0; i < 64; ++i) deadline.Note(8 * kMs);
  EXPECT_EQ(deadline.WaitNs(), 50 * kMs);
}

}  // namespace
}  // namespace haptometer::acquire
