#pragma once

#include <cstddef>

#include "acquire/protocol/wire.h"
#include "base/clock.h"

namespace haptometer::acquire::emulator {

/// One direction of an asynchronous wire (8N1, or as told): says when each byte has crossed it.
///
/// Bytes that follow each other without a pause are counted from the start of their burst, so no
/// rounding adds up: byte n of a burst ends at start + bits n / baud (protocol/wire.h).
class SerialLine {
 public:
  explicit SerialLine(int baud, int bits_per_character = kBitsPerCharacter)
      : baud_(baud), bits_per_character_(bits_per_character) {}

  /// Sends one byte that is ready at `ready`, behind those sent before, and returns when its last
  /// bit has arrived. `ready` may lie before the previous byte's end, never before the previous
  /// `ready`.
  MonotonicNs Send(MonotonicNs ready);

 private:
  int baud_;
  int bits_per_character_;
  MonotonicNs burst_start_ = 0;
  MonotonicNs burst_end_ = 0;
  std::size_t burst_bytes_ = 0;
};

}  // namespace haptometer::acquire::emulator
