#include "tools/cli/progress.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace haptometer::cli {
namespace {

TEST(ProgressBar, SaysWhatIsDoneAndWhatIsLeft) {
  EXPECT_EQ(ProgressBar("a.bin", 0.5, 12), "a.bin  [##########----------]  50 %, 12 s left");
  EXPECT_EQ(ProgressBar("a.bin", 0.75, 3), "a.bin  [###############-----]  75 %, 1 s left");
}

TEST(ProgressBar, SaysNothingOfTheRestBeforeAnythingIsDone) {
  EXPECT_EQ(ProgressBar("a.bin", 0, 5), "a.bin  [--------------------]   0 %");
}

TEST(ProgressBar, IsFullOnlyWhenAllIsDone) {
  EXPECT_EQ(ProgressBar("a", 0.9999, 1), "a  [###################-]  99 %, 0 s left");
  EXPECT_EQ(ProgressBar("a", 2, 1), "a  [####################] 100 %, 0 s left");
}

TEST(SecondsPerItem, TriesTheFirstTheMiddleAndTheLast) {
  std::vector<std::uint64_t> tried;
  const double seconds =
      SecondsPerItem(10, 111, [&](std::uint64_t item) { tried.push_back(item); });
  EXPECT_EQ(tried, (std::vector<std::uint64_t>{10, 60, 110}));
  EXPECT_GE(seconds, 0);
  EXPECT_EQ(SecondsPerItem(3, 3, [&](std::uint64_t) { ADD_FAILURE() << "there is none"; }), 0);
  tried.clear();
  (void)SecondsPerItem(0, 2, [&](std::uint64_t item) { tried.push_back(item); });
  EXPECT_EQ(tried, (std::vector<std::uint64_t>{0, 1}));
}

TEST(WorkLine, SaysWhatIsDoneForHowLongAndHowToEndIt) {
  EXPECT_EQ(
      WorkLine("simulate", "playing the run", 0.379, 12.4),
      "simulate: playing the run: 37 % of the most work that is tried, 12 s, 20 s left; Ctrl-C "
      "ends it");
  EXPECT_EQ(
      WorkLine("simulate", "looking", 1.5, 3),
      "simulate: looking: 100 % of the most work that is tried, 3 s, 0 s left; Ctrl-C ends it");
  EXPECT_EQ(WorkLine("simulate", "looking", 0.001, 3),
            "simulate: looking: 0 % of the most work that is tried, 3 s; Ctrl-C ends it");
}

}  // namespace
}  // namespace haptometer::cli
