#pragma once

#include <vector>

#include "trial/import/table/csv_rows.h"
#include "trial/record.h"

namespace haptometer::trial {

/// Sets segment->copies and first_copy: its rows that repeat the time and every value of the row
/// before because they were written twice, and not because the time has few digits and the readings
/// hardly vary.
///
/// Of n rows with the time of the row before, m repeat its values too; of the d rows next to them
/// with another time than the row before, u do. The m rows are copies where m/n > u/d and
///   - the likelihood ratio of two shares against a common one, q = (m + u) / (n + d), is above
///     1000: n D(m/n || q) + d D(u/d || q) > ln 1000, D the relative entropy of two-valued
///     variables;
///   - chance explains at most a tenth of them: p (n - m) / (1 - p) <= m / 10, p = u/d.
/// So at least 5 are. Where no row next to them repeats values (u = 0), d and u are also counted up
/// to 512 rows from them, and the conditions hold for these numbers, too, if u/d <= 1 %: one row is
/// enough where no other of 370 repeats its values.
///
/// `channels`: of the record of which `segment` is a part. Cost: O(min(1000 n, rows) channels), no
/// allocation.
void MarkRowsWrittenTwice(const std::vector<Channel>& channels, CsvRows::Segment* segment);

}  // namespace haptometer::trial
