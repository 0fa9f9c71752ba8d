#pragma once

#include <string_view>
#include <vector>

namespace haptometer::trial {

/// One line of a table with the separator that it suggests.
struct TableCells {
  char separator = ',';
  std::vector<std::string_view> cells{};
};

/// `line` without blanks and a carriage return at its ends; tabs stay, because they separate empty
/// cells there.
[[nodiscard]] std::string_view LineWithTabs(std::string_view line);

/// The cells of `line`, without blanks and quotes around them, into `cells`.
void SplitCells(std::string_view line, char separator, std::vector<std::string_view>* cells);
[[nodiscard]] std::vector<std::string_view> SplitCells(std::string_view line, char separator);

/// The cells of a line whose separator is not known: semicolon where there is one, else tab, else
/// comma. Separators within quotes do not count.
[[nodiscard]] TableCells CellsOf(std::string_view line);

/// Whether a row of a table of numbers can look so: numbers, a time on the clock as the first, and
/// cells that say why there is no number (ReadNoNumber); at least one is a number.
[[nodiscard]] bool IsNumbers(const std::vector<std::string_view>& cells);

}  // namespace haptometer::trial
