#pragma once

#include <vector>

#include "acquire/sensor/sensor.h"

namespace haptometer::acquire {

/// Marks readings that may be the same buffer content of the unit handed out once more.
///
/// The unit refreshes its buffer every `refresh_ns` and M0 reads the buffer, so a faster poll gets
/// a content twice. Equal numbers do not prove that: a target at rest gives them too. What can be
/// known: a content that was first seen at t is replaced by t + refresh at the latest. So
///   - a reading that differs in any value is new;
///   - an equal one that was polled at t + refresh or later is new, and starts its own t;
///   - an equal one before that cannot be told from a repetition and is marked kRepeated.
/// Times are those of the requests: the unit samples its buffer at a fixed delay behind them, and
/// they do not suffer from the delays of USB on the way back.
class RepeatMarker {
 public:
  explicit RepeatMarker(MonotonicNs refresh_ns) : refresh_ns_(refresh_ns) {}

  /// Turns kOk into kRepeated in `reading` where the rule says so.
  void Mark(Reading& reading);

 private:
  MonotonicNs refresh_ns_;
  MonotonicNs first_seen_ns_ = 0;
  std::vector<trial::Sample> content_;  ///< as sent, before marking; empty before the first
};

}  // namespace haptometer::acquire
