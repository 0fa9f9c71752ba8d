#pragma once

#include <cstddef>
#include <functional>
#include <initializer_list>
#include <string_view>

#include "base/error.h"

namespace haptometer {

/// Does one job by its number.
using Worker = std::function<Result<void>(std::size_t job)>;

/// Does jobs 0, 1, ... `count` - 1, each once, on the caller's and `threads` - 1 further threads.
///
/// `make_worker` is called once on each thread, so a worker may keep buffers from job to job. Jobs
/// are begun in their order. `threads` >= 1. Errors: that of the first job that failed; jobs behind
/// it may be left undone.
[[nodiscard]] Result<void> RunJobs(std::size_t count, int threads,
                                   const std::function<Worker()>& make_worker);

/// Does each of `tasks` once, as RunJobs does jobs. Errors: that of the first task that failed.
[[nodiscard]] Result<void> RunBeside(int threads,
                                     std::initializer_list<std::function<Result<void>()>> tasks);

/// Ends a job, in the order of jobs; empty: nothing to do.
using Finish = std::move_only_function<void()>;
/// Does one job by its number, up to where the order matters.
using OrderedWorker = std::function<Result<Finish>(std::size_t job)>;

/// As RunJobs; what the workers return is called one at a time, that of job 0 first.
///
/// Finishes behind the first job that failed are not called.
[[nodiscard]] Result<void> RunJobsInOrder(std::size_t count, int threads,
                                          const std::function<OrderedWorker()>& make_worker);

/// Who looks on while long work is done: is called with what is being done and with the share of
/// its bound on work that is spent, 0 to 1, once a piece of the work: at no fixed rate.
using Watcher = std::function<void(std::string_view what, double share)>;

/// Has this thread's searches and runs report to `watcher` for as long as this object lives. Of two
/// the younger is told.
class WatchedWork {
 public:
  explicit WatchedWork(Watcher watcher);
  ~WatchedWork();
  WatchedWork(const WatchedWork&) = delete;
  WatchedWork& operator=(const WatchedWork&) = delete;

 private:
  Watcher watcher_;
  const Watcher* before_;
};

/// Tells this thread's watcher; does nothing where there is none. Cost then: a nanosecond.
void ReportWork(std::string_view what, double share);

}  // namespace haptometer
