#pragma once

#include <string>
#include <vector>

#include "base/error.h"

namespace haptometer::tools {

/// Joins the tables of shards into the table that one run would have written, byte for byte; memory
/// of one row a table.
///
/// Errors, with no file left: as cli::OutputFile for `output` (replaced where `replace` says so);
/// as TableReader for a table; Cause::kUsage for tables of different questions, with the
/// difference, and for a point that two of them hold; Cause::kCannotAnswer for a point that none
/// holds or a table that ends amid a row.
[[nodiscard]] Result<void> MergeTables(const std::vector<std::string>& tables,
                                       const std::string& output, bool replace);

}  // namespace haptometer::tools
