#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "trial/record.h"

namespace haptometer::trial {

enum class CsvColumnKind : std::uint8_t { kTime, kValue, kStatus };

/// What a column's name says of it.
struct CsvColumn {
  CsvColumnKind kind = CsvColumnKind::kValue;
  ChannelRole role = ChannelRole::kOther;  ///< kValue
  std::string name{};                      ///< without its unit: "displacement", "displacement_2"
  std::string unit{};                      ///< SI, as values are kept: "m", "V", "A", "s" or ""
  double factor = 1;                       ///< printed value * factor = SI value
  std::size_t channel = 0;  ///< kStatus: the channel it is about, counted from 1; 0: all of them
};

/// Reads a header line's cells: `time_s` (also _ms, _us, _ns), `displacement_mm`, `voltage_v`,
/// `current_ma`, `displacement_2_m`, `trigger`, `status`, `status_2`; any other name is a channel
/// of role kOther without a unit. Upper and lower case are alike.
///
/// Errors (Cause::kCannotAnswer), naming `where`: no time column, two of them, no other column, a
/// time, displacement, voltage or current without a unit that is known.
[[nodiscard]] Result<std::vector<CsvColumn>> ReadCsvColumns(
    const std::vector<std::string_view>& cells, const std::string& where);

/// The column name of the `number`th channel (from 1) of a record, such that ReadCsvColumns gives
/// role and unit back; `ordinal` counts the channels of its role from 1.
[[nodiscard]] std::string CsvColumnName(const Channel& channel, std::size_t number,
                                        std::size_t ordinal);

}  // namespace haptometer::trial
