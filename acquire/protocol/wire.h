#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "base/clock.h"
#include "trial/record.h"

namespace haptometer::acquire {

/// Bits that one character occupies on an asynchronous wire at 8N1: start, 8 data, stop.
inline constexpr int kBitsPerCharacter = 10;

/// How long `bytes` characters occupy the wire: bits x bytes / baud, in nanoseconds, rounded down.
[[nodiscard]] MonotonicNs WireTimeNs(std::size_t bytes, int baud,
                                     int bits_per_character = kBitsPerCharacter);

/// Whether every character of `text` is `character`; false for an empty text.
[[nodiscard]] bool ConsistsOf(std::string_view text, char character);

/// The value of 1 to 9 ASCII digits and nothing else: no sign, no space.
[[nodiscard]] std::optional<std::int32_t> ParseDigits(std::string_view text);

/// 10^exponent for 0 <= exponent <= 9.
[[nodiscard]] std::int32_t PowerOfTen(int exponent);

/// What an error number of a device means, in words a user can act on.
struct ErrorWords {
  int number = 0;
  std::string_view text;
};

/// The text of `number`; "unknown error" where it is not among `known`.
[[nodiscard]] std::string_view ErrorTextIn(std::span<const ErrorWords> known, int number);

/// Stands in Value::counts where the sensor sent letters instead of a number.
inline constexpr std::int32_t kNoCounts = std::numeric_limits<std::int32_t>::min();

/// One value as it was sent: `+01.234` is 1234 counts with 3 decimals. Nothing is rounded or
/// scaled.
struct Value {
  std::int32_t counts = 0;  ///< the digits with their sign, as sent; kNoCounts where there are none
  int decimals = 0;         ///< digits after the point
  trial::SampleStatus status = trial::SampleStatus::kOk;

  friend bool operator==(const Value&, const Value&) = default;
};

}  // namespace haptometer::acquire
