#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace haptometer::trial {

/// Whose layout a table has.
enum class TableFormat : std::uint8_t {
  kPlain,  ///< names, perhaps units, numbers
  kTektronixTds,
  kTektronixDpo,
  kTektronixMso,
  kRigolSequence,
  kRigolSeconds,
  kRigolVolts,
  kRigolDs1204,
  kRigolUltrascope,
  kKeysightInfiniivision,
  kKeysightInfiniium,
  kSiglent,
  kLecroy,
  kPicoscope,
  kSaleae,
  kDigilent,
  kHantek,
  kOpenhantek,
  kRohdeSchwarz,
  kNiPxi,
  kNiElvis,
};

/// What is known of a layout beyond the file's own words.
struct TableFormatFacts {
  TableFormat format = TableFormat::kPlain;
  std::string_view name;   ///< as --format says it: "rigol-sequence"
  std::string_view title;  ///< "Rigol DS1000Z/2000A/4000"
  /// The unit of times and of values where the file does not say one ("" where it always does, or
  /// where nothing is known); the reader says that it took it.
  std::string_view assumed_time_unit;
  std::string_view assumed_value_unit;
};

/// All layouts, kPlain first.
[[nodiscard]] std::span<const TableFormatFacts> TableFormats();
[[nodiscard]] const TableFormatFacts& FactsOf(TableFormat format);
[[nodiscard]] std::optional<TableFormat> TableFormatFromName(std::string_view name);

/// The layout that the first lines of `text` (UTF-8, no byte-order mark) speak of; the first that
/// matches, from the most particular to the least; kPlain where none does. Separators may be
/// commas, semicolons or tabs, as after a spreadsheet. Only the first 64 lines are looked at.
[[nodiscard]] TableFormat FindTableFormat(std::string_view text);

}  // namespace haptometer::trial
