#pragma once

#include <string>
#include <string_view>

#include "base/result.h"

namespace haptometer::tools {

/// Whether `path` may be written: nothing is there, or `overwrite`. An empty path may.
/// Errors: as cli::WholeFile::Begin.
[[nodiscard]] Result<void> CheckOutput(const std::string& path, bool overwrite);

/// Writes `content` as a whole file. Errors: as cli::WholeFile.
[[nodiscard]] Result<void> WriteOutput(const std::string& path, std::string_view content,
                                       bool overwrite);

}  // namespace haptometer::tools
