#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "trial/findings.h"
#include "trial/import/import_options.h"
#include "trial/import/table/csv_header.h"
#include "trial/import/table/stated_clock.h"
#include "trial/import/table/table_cells.h"

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

/// Where the numbers of another program's table begin, and what its columns are.
struct ForeignTable {
  TableFormat format = TableFormat::kPlain;
  std::size_t offset = 0;  ///< of the first line of numbers, in bytes
  std::size_t line = 0;    ///< lines before it
  char separator = ',';
  std::vector<CsvColumn> columns{};
  std::optional<StatedClock> clock{};        ///< as the lines above state it
  std::optional<std::size_t> stated_rows{};  ///< likewise
  /// Where each segment begins on the first one's time, for a file of several that says so.
  std::vector<double> segment_starts_s{};
  std::map<std::string, std::string> fields{};  ///< "table.KEY" of lines "KEY,value" above it
  std::vector<std::string> notes{};             ///< other lines above it
  Findings findings{};                          ///< what was assumed
};

/// Finds the table of numbers in what an oscilloscope or a DAQ's program wrote
/// (docs/reference/formats.md has the list): two lines of numbers that follow each other with as
/// many cells; above them a line that names the columns and perhaps one with their units; or the
/// layout of one maker.
///
/// `options` override what the file says: format, columns, scales; a channel that is not
/// options.channel is left out. Nothing where no two lines of numbers follow each other.
/// Errors (Cause::kCannotAnswer), naming `name`: as ReadNamedColumns and FindStatedClock; no time
/// and no rate; a histogram; no channel or several with the wanted name; another format than
/// options.format says.
/// Cause::kUsage: as ReadNamedColumns, or a scale without a channel that it is about.
[[nodiscard]] Result<std::optional<ForeignTable>> FindForeignTable(std::string_view text,
                                                                   const std::string& name,
                                                                   const ImportOptions& options);

/// Gives displacements options.scale_m, voltages options.scale_v; the only channel, of which
/// nothing says what it measures, is meant by either. Errors (Cause::kUsage): no channel is.
[[nodiscard]] Result<void> ApplyScales(const ImportOptions& options,
                                       std::vector<CsvColumn>* columns);

/// Leaves out all value columns but the one called options.channel, by its name or as its whole
/// cell is printed, where that is not empty; `columns` are numbered (NumberChannels). Errors
/// (Cause::kCannotAnswer), naming `name` and the channels: none is called so, or several.
[[nodiscard]] Result<void> KeepChannel(const ImportOptions& options, const std::string& name,
                                       std::vector<CsvColumn>* columns);

}  // namespace haptometer::trial
