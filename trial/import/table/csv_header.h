#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "trial/import/table/table_cells.h"
#include "trial/record.h"

namespace haptometer::trial {

/// kArrival: when the row arrived, beside a straightened time. kNumber: the row's number
/// (row_numbers.h), of a table without times. kDate: of the time of day beside it (dates.h).
enum class CsvColumnKind : std::uint8_t {
  kTime,
  kArrival,
  kValue,
  kStatus,
  kNumber,
  kDate,
  kLeftOut
};

/// What a column's name says of it.
struct CsvColumn {
  CsvColumnKind kind = CsvColumnKind::kValue;
  ChannelRole role = ChannelRole::kOther;  ///< kValue
  std::string name{};                      ///< without its unit: "displacement", "displacement_2"
  std::string unit{};                      ///< SI, as values are kept: "m", "V", "A", "s" or ""
  double factor = 1;                       ///< printed value * factor + offset = SI value
  double offset = 0;                       ///< SI; of times that count from elsewhere than 0
  bool is_clock = false;  ///< kTime: a time on the wall's clock (ReadClock), counted from the first
  bool is_count = false;  ///< kTime: whole numbers, of which no digit is rounded
  /// kStatus: the channel that it is about, counted from 1; 0: all of them. kValue: its own number
  /// among the file's channels, where it is known.
  std::size_t channel = 0;
  std::string printed{};  ///< the whole cell that named it: "CH1 (V)", "voltage_v"
  /// As printed, where `unit` is empty because it is not known: "mm/s".
  std::string unknown_unit{};
};

/// Gives a value column a unit, its factor, and the role of what is measured in it.
void SetUnit(const PrintedUnit& unit, CsvColumn* column);
/// The same with a unit as printed; leaves the column as it is where the unit is not known.
void SetPrintedUnit(std::string_view printed, CsvColumn* column);

/// Reads one column's name, as below; "-" is a column to leave out.
[[nodiscard]] Result<CsvColumn> ReadCsvColumn(std::string_view cell, const std::string& where);

/// Reads a header line's cells: `time_s` (also _ms, _us, _ns), `displacement_mm`, `voltage_v`,
/// `current_ma`, `displacement_2_m`, `arrival_s`, `trigger`, `status`, `status_2`; any other name
/// is a channel of role kOther without a unit. Upper and lower case are alike.
///
/// Errors (Cause::kCannotAnswer), naming `where`: no time column, two of them, no other column, a
/// time, displacement, voltage or current without a unit that is known.
[[nodiscard]] Result<std::vector<CsvColumn>> ReadCsvColumns(
    const std::vector<std::string_view>& cells, const std::string& where);

/// Numbers the value columns (CsvColumn::channel) from 1.
void NumberChannels(std::vector<CsvColumn>* columns);

/// A column name for each of `channels`, such that ReadCsvColumns gives role and unit back:
/// "displacement_m", "displacement_2_m", "trigger", "channel_3". No two are alike. Exports to other
/// formats name their columns in the same way.
[[nodiscard]] std::vector<std::string> CsvColumnNames(const std::vector<Channel>& channels);

/// What the `#` lines of a CSV say.
struct CsvComments {
  Metadata metadata{};
  std::vector<Stretch> stretches{};  ///< `# stretch = FIRST_ROW ROWS START_S RATE_HZ UNCERTAINTY_S`
  /// `# times = grid | arrived | polled | known`: with the latter three arrival_s (or time_s, where
  /// there is no arrival_s) holds times as they came.
  Timing timing = Timing::kUniform;
  bool times_are_known = false;  ///< Record::times_are_known
  /// `# channel.2.name = CH2`: {"2.name": "CH2"}
  std::map<std::string, std::string> channel_keys{};
};

/// Takes one `#` line (without line end): `# key = value`, or a note.
///
/// Keys that have a place in Metadata go there; `label.NAME` to its labels; `note` to its notes;
/// others to metadata.fields as text. Errors (Cause::kCannotAnswer), naming `where`: a known key
/// whose value is no number.
[[nodiscard]] Result<void> ReadCsvComment(std::string_view line, const std::string& where,
                                          CsvComments* comments);

/// The `# key = value` lines that ReadCsvComment turns back into `metadata`. What is not printable
/// in a value is escaped (base/text.h).
[[nodiscard]] std::string CsvMetadataLines(const Metadata& metadata);

/// One `# key = value` line; nothing for an empty value.
[[nodiscard]] std::string CsvCommentLine(std::string_view key, std::string_view value);

}  // namespace haptometer::trial
