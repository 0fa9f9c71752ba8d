#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "trial/import/stated_clock.h"
#include "trial/import/table_cells.h"

namespace haptometer::trial {

/// A line above a table's numbers.
struct TableLine {
  std::string_view text{};  ///< without blanks at its ends, but with tabs
  std::size_t offset = 0;   ///< of its first byte
  std::size_t number = 0;   ///< lines before it
  std::optional<TableKey> key{};
};

/// What stands above a table's numbers, and its first two rows.
struct TableBeginning {
  std::vector<TableLine> above{};            ///< without lines of empty cells and # lines
  std::vector<TableKey> keys{};              ///< of all lines above, # lines too
  std::vector<std::string_view> comments{};  ///< the # lines
  std::array<TableCells, 2> rows{};
  std::size_t offset = 0;        ///< of the first row
  std::size_t line = 0;          ///< lines before it
  bool ends_in_comment = false;  ///< the line right above is a # line

  [[nodiscard]] std::size_t width() const { return rows[0].cells.size(); }
  /// The line `back` lines above the numbers as cells of their separator, without the empty ones
  /// that a separator at its end makes; empty where there is none.
  [[nodiscard]] std::vector<std::string_view> Above(std::size_t back) const;
  /// The same of the last # line, without its # and where nothing but # lines stands below it; a
  /// program that marks its line of names as a comment (numpy.savetxt) puts it there.
  [[nodiscard]] std::vector<std::string_view> LastComment() const;

 private:
  [[nodiscard]] std::vector<std::string_view> CellsOfWords(std::string_view words) const;
};

/// The first two lines of numbers that follow each other with as many cells, and what is above
/// them; nothing where the first 1000 lines hold none.
[[nodiscard]] std::optional<TableBeginning> FindTableBeginning(std::string_view text);

/// The same of a table whose numbers begin in the first line, in the columns from `first` on, with
/// one key a line before them (Tektronix TDS).
[[nodiscard]] std::optional<TableBeginning> FindSideTable(std::string_view text, std::size_t first);

}  // namespace haptometer::trial
