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

TEST(RunJobsInOrder, EndsJobsInTheirOrder) {
  for (const int threads : {1, 2, 7}) {
    std::vector<std::size_t> ended;
    const auto result = RunJobsInOrder(1000, threads, [&] {
      return [&ended](std::size_t job) -> Result<Finish> {
        return [&ended, job] { ended.push_back(job); };
      };
    });
    EXPECT_TRUE(result);
    ASSERT_EQ(ended.size(), 1000U);
    for (std::size_t k = 0; k < ended.size(); ++k) EXPECT_EQ(ended[k], k);
  }
}

TEST(RunJobsInOrder, EndsNoneBehindAFailure) {
  for (const int threads : {1, 4}) {
    std::vector<std::size_t> ended;
    const auto result = RunJobsInOrder(100, threads, [&] {
      return [&ended](std::size_t job) -> Result<Finish> {
        if (job == 3 || job == 4) return Failed("job", std::to_string(job));
        return [&ended, job] { ended.push_back(job); };
      };
    });
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().what, "3");
    EXPECT_EQ(ended, (std::vector<std::size_t>{0, 1, 2}));
  }
}

TEST(RunBeside, DoesEachTaskOnceAndGivesTheFirstError) {
  for (const int threads : {1, 2}) {
    std::atomic<int> done = 0;
    const auto task = [&]() -> Result<void> {
      ++done;
      return {};
    };
    EXPECT_TRUE(RunBeside(threads, {task, task, task}));
    EXPECT_EQ(done, 3);
    const auto failed = RunBeside(threads, {task, [] { return Result<void>(Failed("", "no")); }});
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().what, "no");
  }
}

TEST(RunJobs, NoJobIsNoWork) {
  EXPECT_TRUE(RunJobs(0, 3, [] {
    return [](std::size_t /*job*/) -> Result<void> { return Failed("", "called"); };
  }));
}

}  // namespace
}  // namespace haptometer
