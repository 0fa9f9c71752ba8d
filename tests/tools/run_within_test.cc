// A program that is run with a deadline.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cerrno>

#include "tools/plot/script.h"

namespace haptometer::plot {
namespace {

using ::testing::HasSubstr;

constexpr MonotonicNs kLongNs = 60 * kNsPerS;

TEST(RunWithin, TellsHowItEnded) {
  EXPECT_EQ(RunWithin({"sh"}, "exit 0\n", kLongNs).value(), true);
  EXPECT_EQ(RunWithin({"sh"}, "exit 3\n", kLongNs).value(), false);
  EXPECT_EQ(RunWithin({"sh"}, "kill -9 $$\n", kLongNs).value(), false);
}

TEST(RunWithin, HandsOverAllOfALongInputThatNobodyReads) {
  EXPECT_EQ(RunWithin({"true"}, std::string(1'000'000, '#'), kLongNs).value(), true);
  // the last line decides, so it was read
  EXPECT_EQ(RunWithin({"sh"}, std::string(1'000'000, '\n') + "exit 4\n", kLongNs).value(), false);
}

TEST(RunWithin, SaysWhatIsNotInstalled) {
  const auto run = RunWithin({"no-such-program-here"}, "", kLongNs);
  ASSERT_FALSE(run);
  EXPECT_THAT(run.error().Text(), HasSubstr("no-such-program-here is not installed"));
}

TEST(RunWithin, KillsWhatHangs) {
  SystemClock clock;
  const MonotonicNs begin_ns = clock.Now();
  const auto run = RunWithin({"sleep", "1000"}, "", kNsPerS / 10);
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().cause, Cause::kFailed);
  EXPECT_THAT(run.error().Text(), HasSubstr("sleep did not end within 0.1 s"));
  EXPECT_LT(clock.Now() - begin_ns, 500 * kNsPerS);
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1) << "no child is left";
  EXPECT_EQ(errno, ECHILD);
}

}  // namespace
}  // namespace haptometer::plot
