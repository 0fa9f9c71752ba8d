#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "trial/findings.h"
#include "trial/record.h"

namespace haptometer::trial {

/// One "key, value, value ..." line above a table, or "#key: value", "key = value", "key:,value".
struct TableKey {
  std::string_view key;  ///< as printed, without #, quotes, ':' and '=' at its end
  std::vector<std::string_view> values{};
  std::size_t line = 0;  ///< from 1
};

/// The line as a key with values; nothing where it has no value. Siglent's "CH1:" before a value is
/// taken off.
[[nodiscard]] std::optional<TableKey> ReadTableKey(std::string_view line, char separator);

/// The values of the first key that is `name` but for case, blanks and signs; empty where none is.
[[nodiscard]] std::vector<std::string_view> ValuesOf(const std::vector<TableKey>& keys,
                                                     std::string_view name);

/// The clock of a table as the lines above it state it.
struct StatedClock {
  double interval_s = 0;
  std::optional<double> start_s{};  ///< time of the first row
  std::string from{};               ///< the key: "Sample Interval"
  std::string printed{};            ///< the number: "1,000"
};

/// Whether an interval and its rate are finite and above 0.
[[nodiscard]] bool IsSampleInterval(double interval_s);

/// Whether the number of `clock` may group thousands, so that the clock may be another by a factor
/// of 1000: by a comma, or by a point where the numbers below have decimal commas.
[[nodiscard]] bool MayGroupThousands(const StatedClock& clock, bool has_decimal_commas);

/// The sample interval that `keys` state: "Sample Interval", "delta t", "XInc", "Increment",
/// "CLOCK", Yokogawa's "HResolution" (in "HUnit") and the like as a time, or "Sample Rate",
/// "Sampling Frequency (Hz)" as a rate, each with a unit or in SI; and the start: "XOrg",
/// "HOffset", or minus "Trigger Point" or "Zero Index" intervals (which may be fractional).
///
/// Nothing where none is stated. Errors (Cause::kCannotAnswer), naming `name`: values of one line
/// or of two lines that contradict each other, an "HUnit" that is no time.
[[nodiscard]] Result<std::optional<StatedClock>> FindStatedClock(const std::vector<TableKey>& keys,
                                                                 const std::string& name);

/// How many rows the lines above a table say it has ("Record Length", "Samples", "SIZE",
/// "Number of Data points", "Points"); nothing where they do not.
[[nodiscard]] std::optional<std::size_t> FindStatedRows(const std::vector<TableKey>& keys);

/// The rate that a table's words state beside its times: nominal_rate_hz, or the first number with
/// Hz or kHz behind it in a field or note that speaks of a rate or sampling.
[[nodiscard]] std::optional<double> StatedRate(const Metadata& metadata);

/// Finds that the times of `record` and the rate that it states are a power of a thousand apart, as
/// they are when milliseconds stand in a column of seconds. The times are used all the same.
void FindContradictedRate(const Record& record, Findings& findings);

}  // namespace haptometer::trial
