#include "acquire/recorder/interval_statistics.h"

#include <cmath>

namespace haptometer::acquire {

void IntervalStatistics::Add(MonotonicNs time_ns) {
  if (!has_time_) {
    has_time_ = true;
    last_ns_ = time_ns;
    return;
  }
  const double interval_s = SecondsFromNs(time_ns - last_ns_);
  total_ns_ += time_ns - last_ns_;
  last_ns_ = time_ns;
  ++intervals_;
  const double deviation_s = interval_s - mean_s_;
  mean_s_ += deviation_s / static_cast<double>(intervals_);
  squares_s2_ += deviation_s * (interval_s - mean_s_);
}

std::optional<double> IntervalStatistics::RateHz() const {
  if (total_ns_ <= 0) return std::nullopt;
  return static_cast<double>(intervals_) / SecondsFromNs(total_ns_);
}

std::optional<double> IntervalStatistics::DeviationSeconds() const {
  if (intervals_ < 2) return std::nullopt;
  return std::sqrt(squares_s2_ / static_cast<double>(intervals_ - 1));
}

}  // namespace haptometer::acquire
