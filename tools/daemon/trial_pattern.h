#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/error.h"

namespace haptometer::tools {

/// How the daemon names its trials: a pattern with {name} (the sensor's), {utc} (when the file was
/// begun, 20260301T120000Z) and {part} (0001, 0002, ... of one uninterrupted recording).
struct TrialPattern {
  std::string directory;
  std::string file = "{name}-{utc}-{part}.bin";
};

/// Errors (Cause::kUsage), naming `where`: empty, a directory in it, another brace, no {name} for
/// several `sensors`.
[[nodiscard]] Result<void> CheckPattern(std::string_view file, std::size_t sensors,
                                        std::string_view where);

/// The path of the next trial. `utc` is UtcNow()'s. Where a file of this name is there already (the
/// wall clock was set back), "-2", "-3", ... makes it another.
[[nodiscard]] std::string NextTrialPath(const TrialPattern& pattern, std::string_view name,
                                        std::string_view utc, std::uint64_t part);

}  // namespace haptometer::tools
