#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "trial/import/csv_rows.h"
#include "trial/import/import_options.h"
#include "trial/import/stated_clock.h"
#include "trial/record.h"

namespace haptometer::trial {

/// What there is to say of a foreign table's times beside the times themselves.
struct TimeWords {
  std::optional<StatedClock> clock{};
  std::vector<double> segment_starts_s{};
};

/// Sets stretches, timing and raw times of `record` from its segments, of which options.segment
/// keeps one (then `record`'s channels are cut to its rows); `rows.segments()` are used up.
///
/// A stated clock beats the printed times where their digits explain how they differ from it, and
/// is the only word where there are none. What was assumed goes to `remarks`.
/// Errors (Cause::kCannotAnswer), naming `name`: times that contradict the stated clock by more
/// than 0.1 % (both are named; options.rate_hz decides), times that repeat without a grid that
/// explains it, several segments of which nothing tells when they were, a segment that is not
/// there or has one row.
[[nodiscard]] Result<void> SetForeignTimes(const std::string& name, const TimeWords& words,
                                           const ImportOptions& options, CsvRows* rows,
                                           Record* record, std::vector<std::string>* remarks);

}  // namespace haptometer::trial
