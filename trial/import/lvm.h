#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "trial/record.h"

namespace haptometer::trial {

/// Whether `text` begins as a LabVIEW measurement file does.
[[nodiscard]] bool IsLvm(std::string_view text);

/// A measurement from the text of a LabVIEW measurement file (.lvm), versions 0 to 2 of the text
/// form (National Instruments, "Specification for the LabVIEW Measurement File (.lvm)").
///
/// Channels, their names and units (Y_Unit_Label), decimal point or comma, tabs or commas between
/// cells, X_Columns No, One or Multi (whose columns must agree), the comment column (kept as notes)
/// and several segments with a header each are understood. A segment's rows start at its X0; where
/// that does not lie behind the segment before, at its Date and Time instead. Each segment is at
/// least one stretch. A unit of length makes a displacement, one of voltage or current a voltage or
/// current. The file's header is kept as fields ("lvm.Date"); the zone of its Time is not in the
/// file, so utc_start stays empty.
///
/// Errors (Cause::kCannotAnswer), naming the line: no header end, a cell that is no number,
/// segments with other channels, X columns that differ, X values that do not grow, segments whose
/// order in time the file does not tell, fewer than two rows. Memory: the record.
[[nodiscard]] Result<Record> ParseLvm(std::string_view text, const std::string& name);

}  // namespace haptometer::trial
