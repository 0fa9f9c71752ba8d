#pragma once

#include <cstddef>

#include "base/clock.h"

namespace haptometer::acquire {

/// Bits that one character occupies on an asynchronous wire at 8N1: start, 8 data, stop.
inline constexpr int kBitsPerCharacter = 10;

/// A signal of frequency f needs at least 2.56 f readings a second to be told from its alias with
/// room for an anti-alias filter's slope; this is the customary factor of vibration analysers.
inline constexpr double kReadingsPerPeriod = 2.56;

/// How long `bytes` characters occupy the wire: bits x bytes / baud, in nanoseconds, rounded down.
[[nodiscard]] MonotonicNs WireTimeNs(std::size_t bytes, int baud,
                                     int bits_per_character = kBitsPerCharacter);

/// Highest frequency that a reading rate can show: rate / 2.56, in Hz.
[[nodiscard]] double HighestObservableHz(double rate_hz);

}  // namespace haptometer::acquire
