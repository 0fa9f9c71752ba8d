#pragma once

#include <string>

#include "base/error.h"
#include "tools/sweep/table_file.h"

namespace haptometer::tools {

/// Whether a sweep can be drawn: one or two varied keys, the whole and not a shard, and a path that
/// a plot can be written to. Errors (Cause::kUsage), to be asked before the work.
[[nodiscard]] Result<void> CheckPicture(const std::string& path, const TableHeader& header);

/// Draws `column` of the table at `table` over its varied keys: one key as a curve; two of a grid
/// as curves, one for each value of the key that has fewer, up to 8, else as a map by colour where
/// both are evenly spaced numbers (else 8 of the curves); sampled ones as points over each key.
/// Memory: two numbers a point. Errors: as plot::DrawPanels; Cause::kCannotAnswer where nothing is
/// answered.
[[nodiscard]] Result<void> DrawSweep(const std::string& path, const std::string& table,
                                     const std::string& column);

}  // namespace haptometer::tools
