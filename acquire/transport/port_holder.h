#pragma once

#include <string>

namespace haptometer::acquire {

/// Who else has the device at `path` open: "minicom (process 123)", or "" where /proc does not tell
/// (another user's process). Looks at every process; for error messages only.
[[nodiscard]] std::string PortHolder(const std::string& path);

}  // namespace haptometer::acquire
