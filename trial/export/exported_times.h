#pragma once

#include "trial/record.h"

namespace haptometer::trial {

/// What every export calls `time_s`: when row `row` of `record` was measured, in seconds, as well
/// as that is known. On the clean time base, but for readings whose own times are known and lie on
/// no grid: there it is theirs. Times at which somebody asked or heard stand in a column beside it.
[[nodiscard]] inline double ExportedTimeOf(const Record& record, std::size_t row) {
  return record.times_are_known ? record.raw_times_s[row] : TimeOf(record, row);
}

/// Whether raw_times_s hold anything that ExportedTimeOf does not give.
[[nodiscard]] inline bool HasArrivalTimes(const Record& record) {
  return !record.raw_times_s.empty() && !record.times_are_known;
}

}  // namespace haptometer::trial
