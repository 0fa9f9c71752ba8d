#include "acquire/protocol/wire.h"

#include <algorithm>

#include "base/error.h"

namespace haptometer::acquire {

MonotonicNs WireTimeNs(std::size_t bytes, int baud, int bits_per_character) {
  HAPTOMETER_CHECK(baud > 0, "baud = {}", baud);
  // t = bytes * bits per character / baud
  return static_cast<MonotonicNs>(bytes) * bits_per_character * kNsPerS / baud;
}

bool ConsistsOf(std::string_view text, char character) {
  return !text.empty() && std::ranges::all_of(text, [=](char c) { return c == character; });
}

std::optional<std::int32_t> ParseDigits(std::string_view text) {
  // nine digits fit in 32 bits
  if (text.empty() || text.size() > 9) return std::nullopt;
  std::int32_t value = 0;
  for (const char character : text) {
    if (character < '0' || character > '9') return std::nullopt;
    value = value * 10 + (character - '0');
  }
  return value;
}

std::int32_t PowerOfTen(int exponent) {
  HAPTOMETER_CHECK(exponent >= 0 && exponent <= 9, "exponent = {}", exponent);
  std::int32_t power = 1;
  for (int i = 0; i < exponent; ++i) power *= 10;
  return power;
}

std::string_view ErrorTextIn(std::span<const ErrorWords> known, int number) {
  const auto found = std::ranges::find(known, number, &ErrorWords::number);
  return found == known.end() ? "unknown error" : found->text;
}

}  // namespace haptometer::acquire
