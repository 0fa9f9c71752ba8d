#include "base/jobs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <vector>

namespace haptometer {
namespace {

TEST(RunJobs, DoesEachOnceOnAnyNumberOfThreads) {
  for (const int threads : {1, 2, 7}) {
    std::vector<int> done(1000);
    std::atomic<int> workers = 0;
    const auto result = RunJobs(done.size(), threads, [&] {
      ++workers;
      return [&done](std::size_t job) -> Result<void> {
        ++done[job];
        return {};
      };
    });
    EXPECT_TRUE(result);
    EXPECT_EQ(std::ranges::count(done, 1), 1000);
    EXPECT_EQ(workers, threads);
  }
}

TEST(RunJobs, GivesTheFirstError) {
  for (const int threads : {1, 4}) {
    const auto result = RunJobs(100, threads, [] {
      return [](std::size_t job) -> Result<void> {
        if (job == 3 || job == 4) return Failed("job", std::to_string(job));
        return {};
      };
    });
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().what, "3");
  }
}

TEST(RunJobs, NoJobIsNoWork) {
  EXPECT_TRUE(RunJobs(0, 3, [] {
    return [](std::size_t /*job*/) -> Result<void> { return Failed("", "called"); };
  }));
}

}  // namespace
}  // namespace haptometer
