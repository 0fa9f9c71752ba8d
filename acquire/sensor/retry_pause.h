#pragma once

#include <algorithm>
#include <utility>

#include "base/clock.h"

namespace haptometer::acquire {

/// The pauses between attempts to open a device that is away: 50 ms, 100 ms, ... at most 250 ms, so
/// that its return is noticed within a second while the processor sleeps in between.
class RetryPause {
 public:
  /// The next one, in ns.
  [[nodiscard]] MonotonicNs Next() {
    return std::exchange(pause_ns_, std::min(2 * pause_ns_, kLongestNs));
  }
  /// Begins anew, for a device that has gone away again.
  void Reset() { pause_ns_ = kFirstNs; }

 private:
  static constexpr MonotonicNs kFirstNs = 50'000'000;
  static constexpr MonotonicNs kLongestNs = 250'000'000;

  MonotonicNs pause_ns_ = kFirstNs;
};

}  // namespace haptometer::acquire
