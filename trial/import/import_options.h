#pragma once

#include <optional>
#include <string>
#include <vector>

namespace haptometer::trial {

/// What a user says of a foreign table whose own words do not suffice. A trial.bin and an HDF5 need
/// none of it and pass it over.
struct ImportOptions {
  /// The columns from the left, named as a CSV of this program names them ("time_s",
  /// "displacement_mm", "voltage_v", any word for a channel of role other); "-" leaves a column
  /// out. Empty: as the file says.
  std::vector<std::string> columns{};
  /// Rows a second of a table without a time column; of one with, the two must agree.
  std::optional<double> rate_hz{};
  /// Metres for one printed unit of displacement, in place of the column's own unit: of an analog
  /// output recorded in volts, the head's span over the output's.
  std::optional<double> scale_m{};
};

}  // namespace haptometer::trial
