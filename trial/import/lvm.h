#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "trial/import/import_options.h"
#include "trial/record.h"

namespace haptometer::trial {

/// Whether `text` begins as a LabVIEW measurement file does.
[[nodiscard]] bool IsLvm(std::string_view text);

/// A measurement from the text of a LabVIEW measurement file (.lvm), versions 0 to 2 of the text
/// form (National Instruments, "Specification for the LabVIEW Measurement File (.lvm)").
///
/// Channels, their names and units (Y_Unit_Label), decimal point or comma, tabs or commas between
/// cells, X_Columns No, One or Multi (whose columns must agree), the comment column (kept as
/// notes), header lines in any order and several segments with a header each are understood. X0 and
/// Delta_X are the stated clock of a channel of more than one sample: it beats the printed X where
/// their resolution explains the difference. A segment's rows start where that says; where it does
/// not lie behind the segment before, at its Date and Time instead. Each segment is at least one
/// stretch. A unit of length makes a displacement, one of voltage or current a voltage or current.
/// The file's header is kept as fields ("lvm.Date"); the zone of its Time is not in the file, so
/// utc_start stays empty.
///
/// `options`: columns names the channels, or X and the channels, from the left; a channel of
/// another Delta_X than the first can be read on its own (options.channel), at its own X0 and
/// Delta_X. What was assumed goes to `remarks`, which may be nullptr. options.format is passed
/// over.
///
/// Errors (Cause::kCannotAnswer), naming the line: no header end, a cell that is no number,
/// segments with other channels, X columns that differ, X values that fall, an X_Dimension other
/// than Time, channels that differ in Delta_X, X values that contradict Delta_X (options.rate_hz
/// decides), segments whose order in time the file does not tell, fewer than two rows.
/// Cause::kUsage: as ReadNamedColumns. Memory: the record.
[[nodiscard]] Result<Record> ParseLvm(std::string_view text, const std::string& name,
                                      const ImportOptions& options = {},
                                      std::vector<std::string>* remarks = nullptr);

}  // namespace haptometer::trial
