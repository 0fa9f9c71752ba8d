#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace haptometer::acquire {

/// Whether every character of `text` is `character`; false for an empty text.
[[nodiscard]] bool ConsistsOf(std::string_view text, char character);

/// The value of 1 to 9 ASCII digits and nothing else: no sign, no space.
[[nodiscard]] std::optional<std::int32_t> ParseDigits(std::string_view text);

/// 10^exponent for 0 <= exponent <= 9.
[[nodiscard]] std::int32_t PowerOfTen(int exponent);

}  // namespace haptometer::acquire
