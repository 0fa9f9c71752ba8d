#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "acquire/sensor/sensor.h"
#include "trial/trial_writer.h"

namespace haptometer::acquire {

/// A bounded ring between the one thread that reads a sensor and the one that writes its trial.
///
/// Flushing to a slow disk takes seconds at times, and what the kernel keeps for a port meanwhile
/// is 0.7 s at 921600 baud (64 KiB) before it drops bytes. So the reader never waits for the disk,
/// takes no lock for a row and allocates nothing: it appends here, and a row that finds no room is
/// the caller's to count. Memory is taken from the system as it is first used.
class RowRing {
 public:
  /// As many events may wait: they are written within a fraction of a second.
  static constexpr std::size_t kMostEvents = 1000;

  /// Room for as many rows of `channels` values as `bytes` hold, at least one.
  RowRing(std::size_t bytes, std::size_t channels);

  // --- the reading thread ---

  /// Adds a row whose times count from `origin_ns`; false when there is no room.
  [[nodiscard]] bool Push(const Reading& reading, MonotonicNs origin_ns);
  /// Rows that there is room for: none while kMostEvents events wait for the disk, since each row
  /// of a damaged source may bring one, and an event costs far more than a row.
  [[nodiscard]] std::size_t room() const;
  /// Rows that there is room for when nothing waits.
  [[nodiscard]] std::size_t capacity() const { return capacity_; }
  /// Adds an event after the rows so far. Rare: takes a lock and allocates.
  void PushEvent(trial::Event event);
  /// No row and no event comes any more.
  void Close() { closed_.store(true, std::memory_order_release); }

  // --- the writing thread ---

  /// Waits for something to take, a fiftieth of a second at most. False once the ring is closed and
  /// everything was taken.
  [[nodiscard]] bool Wait();
  /// The next row, which stays until Pop(), or nothing.
  [[nodiscard]] std::optional<trial::Row> Front();
  /// The event that belongs before the row that Front() showed, if there is one. Ask after Front():
  /// whoever sees a row sees every event that was added before it.
  [[nodiscard]] std::optional<trial::Event> TakeEvent();
  void Pop();

  // --- either ---

  /// The writer cannot go on.
  void GiveUp() { given_up_.store(true, std::memory_order_release); }
  [[nodiscard]] bool given_up() const { return given_up_.load(std::memory_order_acquire); }

 private:
  // without initialisers, so that memory of rows that never come is never touched
  struct Slot {
    std::int64_t index;
    MonotonicNs time_ns;
    MonotonicNs reply_ns;
  };

  [[nodiscard]] std::size_t free_slots() const;

  std::size_t channels_;
  std::size_t capacity_;
  std::unique_ptr<Slot[]> slots_;          // NOLINT(*-avoid-c-arrays): a vector would touch all
  std::unique_ptr<std::uint64_t[]> bits_;  // NOLINT(*-avoid-c-arrays): (capacity x channels)
  std::unique_ptr<trial::SampleStatus[]> status_;  // NOLINT(*-avoid-c-arrays): the same
  std::vector<trial::Sample> front_;               ///< (channels) what Front() shows

  std::atomic<std::uint64_t> pushed_{0};  ///< written by the reading thread
  std::atomic<std::uint64_t> popped_{0};  ///< written by the writing thread
  std::atomic<bool> closed_{false};
  std::atomic<bool> given_up_{false};

  std::atomic<std::size_t> events_waiting_{0};
  std::mutex events_mutex_;
  std::deque<std::pair<std::uint64_t, trial::Event>> events_;  ///< each after so many rows
};

}  // namespace haptometer::acquire
