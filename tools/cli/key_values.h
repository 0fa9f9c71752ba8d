#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace haptometer::cli {

/// "subject=3" and its like, split at the first '='; the last word on a key counts.
///
/// Errors (Cause::kUsage), naming `option`: a word without '=' or without a key.
[[nodiscard]] Result<std::map<std::string, std::string>> ReadKeyValues(
    const std::vector<std::string>& words, std::string_view option);

}  // namespace haptometer::cli
