#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "trial/import/import_options.h"
#include "trial/trial_reader.h"

namespace haptometer::trial {

/// One column of a table whose cells came as numbers.
struct NumberColumn {
  std::string name{};  ///< as the file calls it; empty where it does not
  std::vector<double> values{};
  bool is_count = false;  ///< whole numbers, of which no digit is rounded
  /// One a row, where the file states more than its numbers do; empty: NaN and infinity are
  /// kInvalid, all others kOk.
  std::vector<SampleStatus> statuses{};
};

/// A table of numbers that another program stored in binary: HDF5, NPY, MAT, WAV.
struct NumberTable {
  std::vector<NumberColumn> columns{};
  std::optional<double> rate_hz{};  ///< as the file states it, > 0 and finite
};

/// The columns of a matrix of `rows` x `columns` numbers, row by row (`is_by_row`) or column by
/// column: as many as options.columns names, without names, along the side that has that number
/// (the second where both have); a matrix of one row or one column is one column called
/// `label`. Errors (Cause::kCannotAnswer), naming `name`: options.columns fits neither side.
[[nodiscard]] Result<std::vector<NumberColumn>> ColumnsOfMatrix(
    std::vector<double> numbers, std::size_t rows, std::size_t columns, bool is_by_row,
    const std::string& label, const std::string& name, const ImportOptions& options);

/// A table as a recording, by the rules of a CSV (trial/import/table/csv_header.h, row_times.h):
/// column names carry role and unit; `COLUMN_status` holds the statuses of COLUMN as numbers of a
/// byte; times lie on the grid that explains them, else they are the readings' own.
///
/// `options`: columns names the columns from the left; rate, scale, channel and calibration as for
/// a CSV; a layout is passed over with a finding. `kind`: of the file.
/// Errors (Cause::kCannotAnswer), naming `name`: columns of different lengths or without names, no
/// times and no rate, times that fall or are not finite or against options.rate_hz, statuses that
/// are none, fewer than two rows. Cause::kUsage: columns or scale name what is not there. Memory:
/// the record and one more column.
[[nodiscard]] Result<Recording> ReadNumberTable(NumberTable table, FileKind kind,
                                                const std::string& name,
                                                const ImportOptions& options);

}  // namespace haptometer::trial
