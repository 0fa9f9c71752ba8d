#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "trial/import/csv_column.h"
#include "trial/import/import_options.h"

namespace haptometer::trial {

/// Where the numbers of another program's table begin, and what its columns are.
struct ForeignTable {
  std::size_t offset = 0;  ///< of the first line of numbers, in bytes
  std::size_t line = 0;    ///< lines before it
  char separator = ',';
  std::vector<CsvColumn> columns{};
  std::map<std::string, std::string> fields{};  ///< "table.KEY" of lines "KEY,value" above it
  std::vector<std::string> notes{};             ///< other lines above it
};

/// The cells of `line`, without blanks and quotes around them.
[[nodiscard]] std::vector<std::string_view> SplitCells(std::string_view line, char separator);

/// Finds the table of numbers in what an oscilloscope or a DAQ's program wrote: two lines of
/// numbers that follow each other with as many cells; above them a line that names the columns and
/// perhaps one with their units ("Time,Channel A" and "(ms),(V)"; or "Time [s];Laser [mm]").
///
/// A unit of length makes a column a displacement, one of voltage or current a voltage or current;
/// without a unit it is a channel of role other. `options.columns` overrides all names. Nothing
/// where no two lines of numbers follow each other.
/// Errors (Cause::kCannotAnswer), naming `name`: a time without a unit (both readings are named),
/// no names, no time and no rate, decimal commas that cannot be told from separators.
/// Cause::kUsage: `options` name more or fewer columns than there are, or a scale without a
/// displacement.
[[nodiscard]] Result<std::optional<ForeignTable>> FindForeignTable(std::string_view text,
                                                                   const std::string& name,
                                                                   const ImportOptions& options);

}  // namespace haptometer::trial
