#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "trial/import/table_format.h"

namespace haptometer::trial {

/// What a user says of a foreign table whose own words do not suffice. A trial.bin and an HDF5 need
/// none of it and pass it over.
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
  /// The layout, in place of the one that the file's first lines speak of.
  std::optional<TableFormat> format{};
  /// The one channel to read, by its name as the file prints it ("CH2", "Channel B"; upper and
  /// lower case and blanks are alike). Empty: all.
  std::string channel{};
  /// Which segment to read of a file whose times begin again, from 1.
  std::optional<std::size_t> segment{};
};

}  // namespace haptometer::trial
