#pragma once

#include <cstdint>
#include <optional>

#include "base/clock.h"

namespace haptometer::acquire {

/// Mean rate and scatter of the intervals between times, while they come (Welford's recurrence,
/// which does not cancel where a sum of squares would). O(1) a time.
class IntervalStatistics {
 public:
  void Add(MonotonicNs time_ns);
  /// The interval up to the next time is none of the source's: it does not count.
  void Restart() { has_time_ = false; }

  /// Intervals per second of their own time; empty where no time has passed.
  [[nodiscard]] std::optional<double> RateHz() const;
  /// Standard deviation of the intervals in s (divided by n - 1); empty below two intervals.
  [[nodiscard]] std::optional<double> DeviationSeconds() const;

 private:
  std::uint64_t intervals_ = 0;
  bool has_time_ = false;
  MonotonicNs total_ns_ = 0;
  MonotonicNs last_ns_ = 0;
  double mean_s_ = 0;
  double squares_s2_ = 0;  ///< sum of squared deviations from the mean
};

}  // namespace haptometer::acquire
