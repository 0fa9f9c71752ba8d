#include "tools/daemon/guarded_trials.h"

#include <fmt/core.h>
#include <sys/statvfs.h>

#include <utility>

namespace haptometer::tools {
namespace {

constexpr MonotonicNs kLookEveryNs = kNsPerS / 5;

}  // namespace

std::optional<std::uint64_t> FreeBytes(const std::string& directory) {
  struct statvfs disk{};
  if (statvfs(directory.c_str(), &disk) != 0) return std::nullopt;
  return std::uint64_t{disk.f_bavail} * disk.f_frsize;
}

void GuardedTrials::LookAtDisk() {
  const MonotonicNs now_ns = clock_.Now();
  watched_.pulse.Beat(now_ns);
  if (disk_is_low_ || now_ns < next_look_ns_) return;
  next_look_ns_ = now_ns + kLookEveryNs;
  const auto free_bytes = FreeBytes(watched_.directory);
  disk_is_low_ = free_bytes && *free_bytes < watched_.reserve_bytes;
  if (disk_is_low_) watched_.stop.store(true);
}

Result<void> GuardedTrials::Append(const trial::Row& row) {
  LookAtDisk();
  return trials_.Append(row);
}

Result<void> GuardedTrials::AddEvent(trial::Event event) {
  return trials_.AddEvent(std::move(event));
}

Result<void> GuardedTrials::FlushIfDue() {
  LookAtDisk();
  return trials_.FlushIfDue();
}

Result<void> GuardedTrials::Finish() {
  if (disk_is_low_) {
    trial::Event event;
    event.kind = trial::EventKind::kRemark;
    event.text =
        fmt::format("closed: less than {} bytes are free on the disk", watched_.reserve_bytes);
    if (auto added = trials_.AddEvent(std::move(event)); !added) return added;
  }
  return trials_.Finish();
}

}  // namespace haptometer::tools
