#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tools/campaign/campaign_plan.h"
#include "tools/campaign/slurm.h"

namespace haptometer::tools {
namespace {

TEST(RangesOf, NamesEachNumberOnce) {
  EXPECT_EQ(RangesOf({}), "");
  EXPECT_EQ(RangesOf({5}), "5");
  EXPECT_EQ(RangesOf({1, 2, 3, 4}), "1-4");
  EXPECT_EQ(RangesOf({1, 3, 4, 7, 9, 10, 11}), "1,3-4,7,9-11");
}

TEST(WithoutOptions, RemovesOptionsWithTheirValues) {
  const std::vector<std::string> words{"sweep", "s.toml", "--slurm", "4",     "-o=f.csv",
                                       "--all", "--best", "x",       "--over"};
  EXPECT_EQ(WithoutOptions(words, {"--slurm", "-o", "--best"}, {"--all", "--overwrite"}),
            (std::vector<std::string>{"sweep", "s.toml", "--over"}));
  EXPECT_EQ(WithoutOptions({"study", "--", "dir", "-ox.csv", "--best=y", "--bester"},
                           {"-o", "--best"}, {}),
            (std::vector<std::string>{"study", "dir", "--bester"}));
  // an option that another begins with, and a value that looks like one
  EXPECT_EQ(WithoutOptions({"--job", "--job-time", "--all", "x"}, {"--job-time"}, {}),
            (std::vector<std::string>{"--job", "x"}));
}

}  // namespace
}  // namespace haptometer::tools
