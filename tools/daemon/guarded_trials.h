#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "acquire/recorder/row_sink.h"
#include "base/clock.h"
#include "tools/daemon/pulse.h"

namespace haptometer::tools {

/// Bytes that may still be written below `directory`; empty where the system does not tell.
[[nodiscard]] std::optional<std::uint64_t> FreeBytes(const std::string& directory);

/// Hands rows on to trials as long as the disk has room, and ends the recording before it is full.
///
/// Five times a second it looks at what is free; below the reserve it asks the recording to stop,
/// and the last trial is closed with a remark that says why. Used by the writing thread.
class GuardedTrials final : public acquire::RowSink {
 public:
  struct Watched {
    std::string directory;
    std::uint64_t reserve_bytes;
    std::atomic<bool>& stop;  ///< set when the room is gone
    Pulse& pulse;             ///< beats with every look at what waits to be written
  };

  /// All must outlive the sink.
  GuardedTrials(acquire::RowSink& trials, Watched watched, Clock& clock)
      : trials_(trials), watched_(std::move(watched)), clock_(clock) {}

  [[nodiscard]] Result<void> Append(const trial::Row& row) override;
  [[nodiscard]] Result<void> AddEvent(trial::Event event) override;
  [[nodiscard]] Result<void> FlushIfDue() override;
  [[nodiscard]] Result<void> Finish() override;

  /// Whether it stopped the recording.
  [[nodiscard]] bool disk_is_low() const { return disk_is_low_; }

 private:
  void LookAtDisk();

  acquire::RowSink& trials_;
  Watched watched_;
  Clock& clock_;
  MonotonicNs next_look_ns_ = 0;
  bool disk_is_low_ = false;
};

}  // namespace haptometer::tools
