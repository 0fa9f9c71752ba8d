#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "trial/findings.h"
#include "trial/import/import_options.h"
#include "trial/import/table/csv_rows.h"
#include "trial/import/table/stated_clock.h"
#include "trial/record.h"

namespace haptometer::trial {

/// What there is to say of a foreign table's times beside the times themselves.
struct TimeWords {
  std::optional<StatedClock> clock{};
  std::vector<double> segment_starts_s{};
};

/// The times of one segment, as a record without channels, by the rules of SetForeignTimes. Rows
/// that are left out (PrintedTimes::Complete) are appended to `left_out`, counted as `segment`
/// counts its first one.
[[nodiscard]] Result<Record> ReadSegmentTimes(const std::string& name, const TimeWords& words,
                                              const ImportOptions& options,
                                              CsvRows::Segment segment,
                                              std::vector<std::size_t>* left_out,
                                              Findings* findings);

/// Times of `rows` rows without any of their own, by options.rate_hz or words.clock; one is there.
[[nodiscard]] Stretch UniformTimes(const TimeWords& words, const ImportOptions& options,
                                   std::size_t rows, Findings* findings);

/// Whether the times of `record` have the rate options.rate_hz, where that is given, to 1 %.
/// Errors (Cause::kCannotAnswer), naming `name` and both rates: they have not.
[[nodiscard]] Result<void> CheckRate(const std::string& name, const ImportOptions& options,
                                     const Record& record);

/// Takes `rows`, which grow, from all channels of `record`.
void LeaveOutRows(const std::vector<std::size_t>& rows, Record* record);

/// Sets the times of `record` from its only segment's, those of a table of our own, whose lines
/// above the rows state `timing` and `stretches`. Rows that are left out (PrintedTimes::Complete)
/// are taken from the channels and go to `findings`.
/// Errors (Cause::kCannotAnswer), naming `name`: times that repeat without a grid that explains it,
/// or that lie closer than a rate can say.
[[nodiscard]] Result<void> SetOwnTimes(const std::string& name, Timing timing,
                                       std::vector<Stretch> stretches, CsvRows* rows,
                                       Record* record, Findings* findings);

/// Sets stretches, timing and raw times of `record` from its segments, of which options.segment
/// keeps one (then `record`'s channels are cut to its rows); `rows.segments()` are used up. Without
/// times, jumps of the rows' numbers begin a stretch (row_numbers.h).
///
/// A stated clock beats the printed times where their digits explain how they differ from it, and
/// is the only word where there are none, if its number has one meaning. What was assumed goes to
/// `findings`. Errors (Cause::kCannotAnswer), naming `name`: times that contradict the stated clock
/// by more than 0.1 % (both are named; options.rate_hz decides), times that repeat without a grid
/// that explains it, several segments of which nothing tells when they were, a segment that is not
/// there or has one row.
[[nodiscard]] Result<void> SetForeignTimes(const std::string& name, const TimeWords& words,
                                           const ImportOptions& options, CsvRows* rows,
                                           Record* record, Findings* findings);

/// Puts the times of a file's segments one behind the other.
class SegmentedTimes {
 public:
  /// Takes the next segment: `part` with stretches and raw times (or none) of its own rows from 0,
  /// all later by `shift_s`. False, and nothing is taken: it does not begin behind the one before.
  [[nodiscard]] bool Append(const Record& part, double shift_s);

  /// Whether a segment that begins at `start_s` lies behind what was taken.
  [[nodiscard]] bool IsBehind(double start_s) const;

  /// Sets the stretches of `record`; its raw times and timing too where a segment had raw times.
  void Complete(Record* record) &&;

 private:
  std::vector<Stretch> stretches_{};
  std::vector<double> raw_times_s_{};
  bool has_raw_ = false;
};

}  // namespace haptometer::trial
