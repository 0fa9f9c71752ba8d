#pragma once

#include <atomic>

#include "base/clock.h"

namespace haptometer::tools {

/// The signs of life of one thread, for the watchdog. Written by that thread, read by any.
class Pulse {
 public:
  void Beat(MonotonicNs now_ns) { beat_ns_.store(now_ns); }
  /// The thread is over, or not begun: nobody expects a beat.
  void Rest() { beat_ns_.store(kResting); }

  /// Whether it rests or has beaten within the last `longest_ns`.
  [[nodiscard]] bool IsAlive(MonotonicNs now_ns, MonotonicNs longest_ns) const {
    const MonotonicNs beat_ns = beat_ns_.load();
    return beat_ns == kResting || now_ns - beat_ns <= longest_ns;
  }

 private:
  static constexpr MonotonicNs kResting = -1;
  std::atomic<MonotonicNs> beat_ns_{kResting};
};

}  // namespace haptometer::tools
