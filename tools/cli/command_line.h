#pragma once

#include <string>
#include <vector>

namespace haptometer::cli {

/// `words` as one line that a POSIX shell takes apart into the same words: what is not plain stands
/// in single quotes, and a word that is not printable (base/text.h) in $'...' with octal
/// escapes (POSIX.1-2024, 2.2.4), so the line is printable always.
[[nodiscard]] std::string CommandLine(const std::vector<std::string>& words);

}  // namespace haptometer::cli
