#pragma once

#include <string>
#include <vector>

namespace haptometer::cli {

/// `words` as one line that a POSIX shell takes apart into the same words: what is not plain stands
/// in single quotes.
[[nodiscard]] std::string CommandLine(const std::vector<std::string>& words);

}  // namespace haptometer::cli
