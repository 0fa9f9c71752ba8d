#pragma once

#include <cstdint>
#include <string>

#include "base/result.h"

namespace haptometer {

/// The whole content of a regular file.
///
/// Errors (Cause::kCannotAnswer): missing, a directory, unreadable, empty, larger than
/// `limit_bytes` (default 2 GiB). Memory: the file's size.
[[nodiscard]] Result<std::string> ReadInputFile(const std::string& path,
                                                std::uint64_t limit_bytes = 2ULL << 30);

}  // namespace haptometer
