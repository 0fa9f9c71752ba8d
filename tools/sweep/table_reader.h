#pragma once

#include <fstream>
#include <optional>
#include <string>

#include "base/error.h"
#include "tools/sweep/sweep_table.h"

namespace haptometer::tools {

/// Reads a table that `sweep` wrote, row by row; memory of one row, which ends at 1 MiB.
class TableReader {
 public:
  /// Errors (Cause::kCannotAnswer): no file, or none that begins as such a table, whole header and
  /// all.
  [[nodiscard]] static Result<TableReader> Open(const std::string& path);

  [[nodiscard]] const TableHeader& header() const { return header_; }
  [[nodiscard]] const std::string& path() const { return path_; }

  /// The next whole row, without its line end; nothing behind the last.
  [[nodiscard]] std::optional<std::string> Next();

  /// Whether `row` is one as this table's rows are written: with a cell a column, and with the
  /// checksum of its cells.
  [[nodiscard]] bool IsRow(const std::string& row) const;

  /// Whether the file ends amid a row: its writer was ended there.
  [[nodiscard]] bool ends_amid_row() const { return ends_amid_row_; }

  /// Bytes up to the end of the last row that Next() gave, or of the header.
  [[nodiscard]] std::uint64_t read_bytes() const { return read_bytes_; }

 private:
  explicit TableReader(const std::string& path);
  [[nodiscard]] Result<void> ReadHeader();

  std::string path_;
  std::ifstream file_;
  TableHeader header_;
  std::uint64_t read_bytes_ = 0;
  bool ends_amid_row_ = false;
};

/// The point of a row, from 1; nothing where it begins with no number.
[[nodiscard]] std::optional<std::uint64_t> PointOfRow(std::string_view row);

}  // namespace haptometer::tools
