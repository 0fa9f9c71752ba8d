#pragma once

#include <string_view>

#include "base/result.h"

namespace haptometer::cli {

/// Prints "haptometer VERB: TEXT" on stderr, in one line, and returns the exit status of its cause.
/// Without a verb: "haptometer: TEXT".
[[nodiscard]] int ReportError(std::string_view verb, const Error& error);

/// The exit status of two answers of which one program speaks: 1 (it failed) before 2 (asked
/// wrongly) before 3 (not answered) before 0. Any other status, an interruption, comes before all.
[[nodiscard]] int WorseStatus(int a, int b);

/// A remark on stderr: "VERB: TEXT".
void Remark(std::string_view verb, std::string_view text);

}  // namespace haptometer::cli
