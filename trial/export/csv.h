#pragma once

#include "base/error.h"
#include "trial/export/piece_sink.h"
#include "trial/record.h"

namespace haptometer::trial {

/// Writes `record` as the CSV that trial/import/csv.h reads: metadata as `# key = value`, then
/// `time_s` (trial/export/exported_times.h), `arrival_s` where raw times stand beside it, a column
/// a channel in SI units, and a status column where any value is not ok.
///
/// Numbers are printed with the fewest digits that give the same double back. Values without a
/// measurement are empty cells, their status says why.
[[nodiscard]] Result<void> WriteCsv(const Record& record, const PieceSink& sink);

}  // namespace haptometer::trial
