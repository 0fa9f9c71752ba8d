#include "base/jobs.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <tuple>
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

// Waits until a worker is gone: then the outcome of its last job is known to the others. Workers
// hold what counts them out.
class Ends {
 public:
  std::shared_ptr<void> Held() {
    return {nullptr, [this](void* /*nothing*/) {
              ++ended_;
              ended_.notify_all();
            }};
  }
  void Await() const { ended_.wait(0); }

 private:
  std::atomic<int> ended_ = 0;
};

// both jobs run at once, and job `first` has failed before the other one does
TEST(RunJobs, GivesTheErrorOfTheEarlierJobWhicheverFailedFirst) {
  for (const std::size_t first : {0U, 1U}) {
    Ends ends;
    std::atomic<int> begun = 0;
    const auto result = RunJobs(2, 2, [&] {
      return [&, first, held = ends.Held()](std::size_t job) -> Result<void> {
        ++begun;
        begun.notify_all();
        begun.wait(1);
        if (job != first) ends.Await();
        return Failed("job", std::to_string(job));
      };
    });
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().what, "0") << first;
  }
}

TEST(RunJobsInOrder, DoesNotEndAJobThatWaitsForOneThatFails) {
  std::atomic<bool> is_done = false;  // the work of job 1
  std::vector<std::size_t> ended;
  const auto result = RunJobsInOrder(2, 2, [&] {
    return [&](std::size_t job) -> Result<Finish> {
      if (job == 0) {
        is_done.wait(false);
        return Failed("job", "0");
      }
      is_done = true;
      is_done.notify_all();
      return [&ended, job] { ended.push_back(job); };
    };
  });
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().what, "0");
  EXPECT_TRUE(ended.empty());
}

// jobs 0 and 1 are still at work when job 2 has failed
TEST(RunJobsInOrder, EndsAllThatIsBeforeAFailure) {
  Ends ends;
  std::vector<std::size_t> ended;
  const auto result = RunJobsInOrder(3, 3, [&] {
    return [&, held = ends.Held()](std::size_t job) -> Result<Finish> {
      if (job == 2) return Failed("job", "2");
      ends.Await();
      return [&ended, job] { ended.push_back(job); };
    };
  });
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().what, "2");
  EXPECT_EQ(ended, (std::vector<std::size_t>{0, 1}));
}

// a job may have nothing to end
TEST(RunJobsInOrder, PassesOverAnEmptyEnd) {
  std::vector<std::size_t> ended;
  EXPECT_TRUE(RunJobsInOrder(5, 2, [&] {
    return [&ended](std::size_t job) -> Result<Finish> {
      if (job % 2 == 0) return Finish();
      return [&ended, job] { ended.push_back(job); };
    };
  }));
  EXPECT_EQ(ended, (std::vector<std::size_t>{1, 3}));
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

TEST(RunJobs, HasNoMoreThreadsThanJobs) {
  for (const int jobs : {1, 2, 5}) {
    std::atomic<int> workers = 0;
    EXPECT_TRUE(RunJobs(static_cast<std::size_t>(jobs), 7, [&] {
      ++workers;
      return [](std::size_t /*job*/) -> Result<void> { return {}; };
    }));
    EXPECT_EQ(workers, jobs);
  }
}

TEST(RunJobsDeathTest, NoThreadIsAnErrorOfTheProgrammer) {
  const auto make_worker = [] { return [](std::size_t /*job*/) -> Result<void> { return {}; }; };
  EXPECT_DEATH(std::ignore = RunJobs(1, 0, make_worker), "threads = 0");
}

TEST(ReportWork, IsToldToTheYoungestWatcherOfItsThread) {
  std::vector<std::string> told;
  const auto watcher = [&told](const char* name) {
    return [&told, name](std::string_view what, double share) {
      told.push_back(fmt::format("{} {} {}", name, what, share));
    };
  };
  ReportWork("nobody watches", 0);
  {
    const WatchedWork older(watcher("older"));
    ReportWork("a", 0.25);
    {
      const WatchedWork younger(watcher("younger"));
      ReportWork("b", 0.5);
      std::jthread([] { ReportWork("another thread", 1); }).join();
    }
    ReportWork("c", 1);
  }
  ReportWork("nobody watches", 1);
  EXPECT_EQ(told, (std::vector<std::string>{"older a 0.25", "younger b 0.5", "older c 1"}));
}

}  // namespace
}  // namespace haptometer
