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

/// A result on stdout. All of a verb's text and JSON goes this way, so that no control character
/// but line ends and tabs reaches a terminal; a name or a path in a line is made one line where the
/// line is made (base/printable.h).
void Print(std::string_view text);

/// A remark on stderr, in one printable line: "VERB: TEXT".
void Remark(std::string_view verb, std::string_view text);

}  // namespace haptometer::cli
