#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "trial/record.h"

namespace haptometer::trial {

/// A measurement from a CSV file: `# key = value` lines, a header line, rows.
///
/// Header line: `time_s` first or anywhere, then columns whose names carry role and unit:
/// displacement_m, voltage_v, current_a, trigger, each optionally in m/u/n units (displacement_mm,
/// voltage_mv, time_ms), converted to SI; other names become ChannelRole::kOther. `status` applies
/// to all columns, `NAME_status` to one. Separator comma, semicolon (then a decimal comma is
/// understood) or tab; a byte-order mark and CRLF are tolerated.
///
/// Every `# key = value` lands in metadata.fields as text; the keys of docs/formats.md (source,
/// sensor, head, sampling_s, ..., label.NAME) also in their place. An empty cell or `nan` is
/// kInvalid.
///
/// Times that differ from a grid by no more than their printed digits explain become one clocked
/// stretch a gap-free run; other times are kept in raw_times_s beside the mean line.
///
/// Errors (Cause::kCannotAnswer): missing, empty, text instead of numbers, no time column, times
/// that do not grow or are not finite, a row with too many or too few cells (the line is named),
/// fewer than two rows. Memory: the file's size and the record.
[[nodiscard]] Result<Record> ReadCsv(const std::string& path);

/// The same from `text`; `name` stands for the path in messages.
[[nodiscard]] Result<Record> ParseCsv(std::string_view text, const std::string& name);

}  // namespace haptometer::trial
