#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "trial/import/import_options.h"
#include "trial/record.h"

namespace haptometer::trial {

/// A measurement from the text of a CSV: `# key = value` lines, a header line, rows.
///
/// Header line: `time_s`, and columns whose names carry role and unit: displacement_m, voltage_v,
/// current_a, trigger, each also in prefixed units (displacement_mm, voltage_mv, time_ms),
/// converted to SI; other names become ChannelRole::kOther. `status` applies to all channels,
/// `status_2` to the second. Separator comma, semicolon, tab or blanks (with the latter three a
/// decimal comma is understood); a byte-order mark and CRLF are tolerated.
/// trial/import/csv_column.h has the rules.
///
/// `# key = value`: keys with a place in Metadata go there (`label.NAME` to the labels), all others
/// to metadata.fields as text, as do those of impulse.csv. An empty cell, `nan` or `inf` is
/// kInvalid; a number beside a status that is no measurement is dropped.
///
/// Times that differ from a grid by no more than their printed digits explain become clocked
/// stretches (trial/import/printed_grid.h); other times are kept in raw_times_s beside their mean
/// line. The
/// `# stretch` lines of an export count where they still describe the rows.
///
/// A table of another program (oscilloscope, DAQ) is read as trial/import/foreign_table.h says;
/// `options` help where its own words do not suffice. Without a time column it needs
/// options.rate_hz. Errors name `name`; what was assumed goes to `remarks`, which may be nullptr.
///
/// Errors (Cause::kCannotAnswer): text instead of numbers, no time column, times that do not grow
/// or are not finite, a row with too many or too few cells (the line is named), a comma that may be
/// a decimal one or group thousands, times against options.rate_hz, fewer than two rows. Memory:
/// the record.
[[nodiscard]] Result<Record> ParseCsv(std::string_view text, const std::string& name,
                                      const ImportOptions& options = {},
                                      std::vector<std::string>* remarks = nullptr);

}  // namespace haptometer::trial
