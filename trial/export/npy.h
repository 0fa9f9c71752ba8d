#pragma once

#include "base/error.h"
#include "trial/export/piece_sink.h"
#include "trial/record.h"

namespace haptometer::trial {

/// Writes `record` as one NumPy array with named fields: `numpy.load(f)["displacement_m"]`.
///
/// Fields: `time_s` (f8, the clean time base), then for each channel its column (f8, SI, NaN where
/// there is no measurement) and `COLUMN_status` (u1, the number of its SampleStatus). Columns are
/// named as in a CSV (trial/import/csv_column.h). Values and statuses keep their bits; metadata and
/// raw times have no place. Form: NumPy format 1.0, or 2.0 where the head of fields needs it.
/// Errors: those of `sink`; Cause::kCannotAnswer where the record holds no channel. Cost: one pass.
[[nodiscard]] Result<void> WriteNpy(const Record& record, const PieceSink& sink);

}  // namespace haptometer::trial
