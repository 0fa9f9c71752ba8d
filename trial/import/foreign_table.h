#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "trial/import/csv_column.h"
#include "trial/import/import_options.h"
#include "trial/import/stated_clock.h"

namespace haptometer::trial {

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
  std::vector<std::string> remarks{};           ///< what was assumed, a sentence each
};

/// Finds the table of numbers in what an oscilloscope or a DAQ's program wrote (docs/formats.md has
/// the list): two lines of numbers that follow each other with as many cells; above them a line
/// that names the columns and perhaps one with their units; or the layout of one maker.
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
