#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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

/// What a user says of a foreign table whose own words do not suffice. A trial.bin and an
/// export of this program as HDF5, NPY, MAT or WAV need none of it and pass it over.
struct ImportOptions {
  /// The columns from the left, named as a CSV of this program names them ("time_s",
  /// "displacement_mm", "voltage_v", any word for a channel of role other); "-" leaves a column
  /// out. Empty: as the file says.
  std::vector<std::string> columns{};
  /// Rows a second of a table without a time column; of one with, the two must agree. Decides where
  /// a header and the times contradict each other, and which unit a time without one has.
  std::optional<double> rate_hz{};
  /// Metres for one printed unit of displacement, in place of the column's own unit: of an analog
  /// output recorded in volts, the head's span over the output's.
  std::optional<double> scale_m{};
  /// Volts for one printed unit of voltage, in place of the column's own unit: of a probe that the
  /// oscilloscope did not know of, or of mV under a header that says V.
  std::optional<double> scale_v{};
  /// A calibration file (trial/calibration.h) that turns the volts of an analog output into a
  /// displacement; empty: none.
  std::string calibration{};
  /// The layout, in place of the one that the file's first lines speak of.
  std::optional<TableFormat> format{};
  /// The one channel to read, by its name as the file prints it ("CH2", "Channel B"; upper and
  /// lower case and blanks are alike). Empty: all.
  std::string channel{};
  /// Which segment to read of a file whose times begin again, from 1.
  std::optional<std::size_t> segment{};
};

}  // namespace haptometer::trial
