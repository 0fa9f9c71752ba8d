#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace haptometer::trial {

/// One line of a table with the separator that it suggests.
struct TableCells {
  char separator = ',';
  std::vector<std::string_view> cells{};
};

/// Bounds of a table, wide of what programs write. With them the memory for reading is a small
/// multiple of the file's size, whatever it holds.
inline constexpr std::size_t kMostColumns = 4096;
inline constexpr std::size_t kMostLineBytes = std::size_t{1} << 20;
inline constexpr std::size_t kMostHeaderLines = 100'000;  ///< that state something to be kept

/// Refuses a text with a line of more than kMostLineBytes or kMostColumns, or with more # lines
/// than kMostHeaderLines, before any of it is split. Errors (Cause::kCannotAnswer) name the line.
/// Cost: one pass, no memory.
[[nodiscard]] Result<void> CheckLines(std::string_view text, const std::string& name);

/// `line` without blanks and a carriage return at its ends; tabs stay, because they separate empty
/// cells there.
[[nodiscard]] std::string_view LineWithTabs(std::string_view line);

/// The cells of `line`, without blanks and quotes around them, into `cells`. With a blank as the
/// separator any run of blanks and tabs outside of quotes and brackets separates, but one in front
/// of an opening bracket, whose unit belongs to the name before: "Time (s)  CH 1" is "Time (s)",
/// "CH", "1".
void SplitCells(std::string_view line, char separator, std::vector<std::string_view>* cells);
[[nodiscard]] std::vector<std::string_view> SplitCells(std::string_view line, char separator);

/// The cells of a line whose separator is not known: semicolon where there is one, else tab, else
/// blanks where they make numbers of it and commas do not, else comma. Separators within quotes do
/// not count.
[[nodiscard]] TableCells CellsOf(std::string_view line);

/// "commas", "semicolons", "tabs" or "blanks".
[[nodiscard]] std::string_view NameOfSeparator(char separator);

/// Whether a row of a table of numbers can look so: numbers, a time on the clock as the first, and
/// cells that say why there is no number (ReadNoNumber); at least one is a number.
[[nodiscard]] bool IsNumbers(const std::vector<std::string_view>& cells);

}  // namespace haptometer::trial
