#pragma once

#include <functional>
#include <string_view>

namespace haptometer::sim {

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

}  // namespace haptometer::sim
