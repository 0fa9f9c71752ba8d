#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace haptometer::tools {

/// A table with names in its first line, whose cells are text.
struct TextTable {
  std::string name;                                         ///< the file, for messages
  char separator = ',';                                     ///< of its cells: , ; or a tab
  std::map<std::string, std::vector<std::string>> columns;  ///< all of `rows` cells
  std::vector<std::size_t> lines;                           ///< (rows) line of each, from 1
  std::vector<std::string> comments;                        ///< lines with '#' above the names
  [[nodiscard]] std::size_t rows() const { return lines.size(); }
};

/// At most 16 MiB and 4096 columns, separated by commas, semicolons or tabs as in the first line
/// (trial/import/table/table_cells.h), with CR LF and any of the encodings there. Lines that begin
/// with
/// '#' and empty ones are passed over; cells may stand in double quotes (RFC 4180, without line
/// ends within them). Errors (Cause::kCannotAnswer): the file's, larger, a line with another number
/// of cells, a name twice, no row, a `required` column that is not there, with the nearest.
[[nodiscard]] Result<TextTable> ReadTextTable(const std::string& path,
                                              const std::vector<std::string>& required);

/// The numbers of a column, with decimal commas; where commas separate the cells, only in quotes
/// and where they cannot group thousands. Errors (Cause::kCannotAnswer), with the line: a cell that
/// is no finite number, or one of a magnitude that no measurement has (base/quantity.h); one with a
/// point where a comma is the decimal sign.
[[nodiscard]] Result<std::vector<double>> NumbersOf(const TextTable& table,
                                                    const std::string& column);

/// A name that a column may have, and what its numbers are multiplied by: to SI.
struct KnownColumn {
  std::string_view name;
  double factor;
};

/// The numbers of the one of `known` that the table has; nothing where it has none. Errors: as
/// NumbersOf; it has two of them.
[[nodiscard]] Result<std::optional<std::vector<double>>> FindColumn(
    const TextTable& table, std::span<const KnownColumn> known);

}  // namespace haptometer::tools
