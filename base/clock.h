#pragma once

#include <cstdint>
#include <string>

namespace haptometer {

/// Nanoseconds on a monotonic clock; only differences mean anything.
using MonotonicNs = std::int64_t;

inline constexpr MonotonicNs kNsPerS = 1'000'000'000;

/// Seconds in nanoseconds, rounded to the nearest.
[[nodiscard]] MonotonicNs NsFromSeconds(double seconds);

/// Nanoseconds in seconds.
[[nodiscard]] double SecondsFromNs(MonotonicNs ns);

/// Where time comes from; injected, so that deadlines are tested without sleeping.
class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual MonotonicNs Now() = 0;
  /// Returns when Now() >= `time`, or earlier when a signal arrives.
  virtual void SleepUntil(MonotonicNs time) = 0;
};

/// CLOCK_MONOTONIC. One instance serves all threads.
class SystemClock final : public Clock {
 public:
  [[nodiscard]] MonotonicNs Now() override;
  void SleepUntil(MonotonicNs time) override;
};

/// A clock that stands still until it is told to move; SleepUntil jumps ahead. One thread only.
class ManualClock final : public Clock {
 public:
  [[nodiscard]] MonotonicNs Now() override { return now_; }
  void SleepUntil(MonotonicNs time) override { now_ = now_ > time ? now_ : time; }
  void Advance(MonotonicNs ns) { now_ += ns; }

 private:
  MonotonicNs now_ = 0;
};

/// The wall clock as `2026-03-01T12:00:00.000Z`: a label for people, never a time base.
[[nodiscard]] std::string UtcNow();

}  // namespace haptometer
