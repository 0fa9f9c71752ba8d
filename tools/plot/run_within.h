#pragma once

#include <string>
#include <vector>

#include "base/clock.h"
#include "base/error.h"

namespace haptometer::plot {

/// Runs a program with `input` on its standard input and nothing else, and waits for its end: at
/// most `longest_ns`, then it is killed. Returns whether it ended with status 0. Of `words` the
/// first is the program, looked for in PATH. Errors (Cause::kFailed, without a place): it is not
/// installed, does not start, or did not end in time.
[[nodiscard]] Result<bool> RunWithin(const std::vector<std::string>& words,
                                     const std::string& input, MonotonicNs longest_ns);

}  // namespace haptometer::plot
