#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace haptometer::cli {

/// `text` as a cell of a table with commas that a program for spreadsheets shows as it is.
///
/// What is not printable is escaped (base/text.h). Such a program takes a cell for a formula
/// that begins with one of `=`, `+`, `-`, `@` or their full-width forms: a text that does, or that
/// begins with apostrophes before one of them, gets an apostrophe in front, unless it is a number.
/// CellsOf() takes it off again, so every printable text comes back as it was. The cell stands in
/// quotes where it holds a comma, a semicolon or a quote, or begins or ends with a blank.
[[nodiscard]] std::string CellOf(std::string_view text);

/// The cells of a line, without their quotes, the apostrophe of CellOf() and blanks around them; in
/// quotes a comma and blanks belong to the cell (RFC 4180).
[[nodiscard]] std::vector<std::string> CellsOf(std::string_view line);

}  // namespace haptometer::cli
