#include "base/jobs.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <limits>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace haptometer {
namespace {

// the error of the earliest job that has failed so far
class FirstError {
 public:
  void Take(std::size_t job, Error error) {
    const std::scoped_lock lock(mutex_);
    // the first error by job number, not by time: the result does not depend on the threads
    if (error_ && job_ < job) return;
    job_ = job;
    error_ = std::move(error);
  }
  [[nodiscard]] Result<void> result() const {
    if (error_) return std::unexpected(*error_);
    return {};
  }

 private:
  std::mutex mutex_;
  std::size_t job_ = 0;
  std::optional<Error> error_;
};

// lets jobs pass one at a time, in their order
class Turns {
 public:
  // waits for the turn of `job`; false where an earlier one has failed
  [[nodiscard]] bool Await(std::size_t job) {
    std::unique_lock lock(mutex_);
    // a failed earlier job would never pass its turn on
    changed_.wait(lock, [&] { return next_ == job || failed_ < job; });
    return next_ == job;
  }
  void Pass() {
    {
      const std::scoped_lock lock(mutex_);
      ++next_;
    }
    changed_.notify_all();
  }
  void Fail(std::size_t job) {
    {
      const std::scoped_lock lock(mutex_);
      // jobs before the failed one still finish
      failed_ = std::min(failed_, job);
    }
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t next_ = 0;
  std::size_t failed_ = std::numeric_limits<std::size_t>::max();
};

}  // namespace

Result<void> RunJobs(std::size_t count, int threads, const std::function<Worker()>& make_worker) {
  HAPTOMETER_CHECK(threads >= 1, "threads = {}", threads);
  std::atomic<std::size_t> next = 0;
  FirstError first_error;
  const auto work = [&] {
    const Worker worker = make_worker();
    // each thread takes the next free number; earlier jobs have begun before later ones
    for (std::size_t job = next++; job < count; job = next++) {
      auto done = worker(job);
      if (done) continue;
      first_error.Take(job, std::move(done.error()));
      // no further job begins
      next = count;
    }
  };
  {
    // this thread works too; no more threads than jobs
    const std::size_t helpers_wanted =
        std::min(static_cast<std::size_t>(threads), std::max<std::size_t>(count, 1)) - 1;
    std::vector<std::jthread> helpers;
    helpers.reserve(helpers_wanted);
    for (std::size_t k = 0; k < helpers_wanted; ++k) helpers.emplace_back(work);
    work();
  }
  // all helpers have ended: jthread joins at the end of its block
  return first_error.result();
}

Result<void> RunBeside(int threads, std::initializer_list<std::function<Result<void>()>> tasks) {
  return RunJobs(tasks.size(), threads, [&]() -> Worker {
    return [&](std::size_t task) { return tasks.begin()[task](); };
  });
}

Result<void> RunJobsInOrder(std::size_t count, int threads,
                            const std::function<OrderedWorker()>& make_worker) {
  Turns turns;
  return RunJobs(count, threads, [&]() -> Worker {
    return [&turns, worker = make_worker()](std::size_t job) -> Result<void> {
      auto finish = worker(job);
      if (!finish) {
        turns.Fail(job);
        return std::unexpected(std::move(finish.error()));
      }
      // work runs in parallel, finishing one after the other in the order of the jobs
      if (!turns.Await(job)) return {};
      if (*finish) (*finish)();
      turns.Pass();
      return {};
    };
  });
}

namespace {

// per thread: a watcher receives only the work of its own thread
thread_local const Watcher* current_watcher = nullptr;

}  // namespace

WatchedWork::WatchedWork(Watcher watcher)
    : watcher_(std::move(watcher)), before_(std::exchange(current_watcher, &watcher_)) {}

WatchedWork::~WatchedWork() { current_watcher = before_; }

void ReportWork(std::string_view what, double share) {
  if (current_watcher != nullptr) (*current_watcher)(what, share);
}

}  // namespace haptometer
