#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "base/error.h"

namespace haptometer {

/// The names of an enum's values 0, 1, 2, ..., in their order.
template <typename Enum, std::size_t kCount>
struct Names {
  std::array<std::string_view, kCount> names;

  [[nodiscard]] std::string_view Of(Enum value) const {
    const auto index = static_cast<std::size_t>(value);
    HAPTOMETER_CHECK(index < kCount, "value {} of {}", index, kCount);
    return names[index];
  }
  /// The value of that name; nothing where none has it.
  [[nodiscard]] std::optional<Enum> From(std::string_view name) const {
    const auto found = std::ranges::find(names, name);
    if (found == names.end()) return std::nullopt;
    return static_cast<Enum>(found - names.begin());
  }
};

}  // namespace haptometer
