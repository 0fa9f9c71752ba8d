#include "base/jobs.h"

#include <utility>

namespace haptometer::sim {

namespace {

thread_local const Watcher* current_watcher = nullptr;

}  // namespace

WatchedWork::WatchedWork(Watcher watcher)
    : watcher_(std::move(watcher)), before_(std::exchange(current_watcher, &watcher_)) {}

WatchedWork::~WatchedWork() { current_watcher = before_; }

void ReportWork(std::string_view what, double share) {
  if (current_watcher != nullptr) (*current_watcher)(what, share);
}

}  // namespace haptometer::sim
