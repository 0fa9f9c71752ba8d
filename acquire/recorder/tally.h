#pragma once

#include "acquire/recorder/gap_counter.h"
#include "acquire/recorder/interval_statistics.h"
#include "acquire/recorder/recorder.h"
#include "acquire/sensor/sensor.h"
#include "base/clock.h"

namespace haptometer::acquire {

/// The reading thread's account of what came. O(1) a row, no allocation.
class Tally {
 public:
  /// `sensor` must outlive the tally; times count from `origin_ns`.
  Tally(const Sensor& sensor, MonotonicNs origin_ns);

  /// The time of a row since the beginning.
  [[nodiscard]] MonotonicNs SinceBegin(const Reading& reading) const;

  /// A reading came; whether it is recorded is not said yet.
  void See() { ++summary_.seen; }
  void Add(const Reading& reading);
  /// Rows that came and were not kept.
  void Lose(std::uint64_t rows);
  /// The device went away, and came back.
  void Leave();
  void Return();
  /// A trigger fired: what is missing before its first row is meant to be.
  void Fire();
  /// The recording ended at `since_begin_ns` by the clock, not by a row.
  void End(MonotonicNs since_begin_ns);

  [[nodiscard]] RecordingSummary Summary() const;

 private:
  void Restart();

  const Sensor& sensor_;
  trial::Timing timing_;
  double rate_hz_;
  MonotonicNs origin_ns_;
  RecordingSummary summary_;
  IntervalStatistics intervals_;
  GapCounter gaps_;
  std::uint64_t known_gaps_ = 0;  ///< beside those that the intervals show
};

}  // namespace haptometer::acquire
