#pragma once

#include <cstddef>
#include <string_view>

#include "base/result.h"

namespace haptometer {

/// Bounds of a TOML text. No file of this program comes near them.
inline constexpr std::size_t kMostTomlBytes = std::size_t{1} << 20;
inline constexpr int kMostTomlLevels = 16;  ///< of brackets in each other, and of a key's parts

/// Refuses a text whose tables would nest too deeply for a parser that calls itself for each level:
/// lists and inline tables in each other, and keys of many parts (`a.b.c`). Brackets and points in
/// strings and comments do not count. Whether the text is TOML is left to the parser.
///
/// Errors (Cause::kCannotAnswer), with the line: more than kMostTomlLevels brackets are open at
/// once, or a key has more parts; without a line: more than kMostTomlBytes. Cost: one pass, no
/// memory.
[[nodiscard]] Result<void> CheckTomlShape(std::string_view text, std::string_view where);

}  // namespace haptometer
