#pragma once

#include <string>

#include "base/error.h"
#include "trial/hdf5_id.h"
#include "trial/import/import_options.h"
#include "trial/import/number_table.h"

namespace haptometer::trial {

/// Whether each link of the path `name` from the root is there; an empty path is the root. libhdf5
/// calls a path whose first links are missing an error.
[[nodiscard]] bool Hdf5Exists(const Hdf5Id& file, const std::string& name);

/// Whether a dataset of numbers of one dimension stands at the root.
[[nodiscard]] bool HasHdf5Column(const Hdf5Id& file);

/// The table at the path `name` of `file`, which is there: as ReadHdf5 (trial/import/readers.h)
/// says. `where` stands for it in messages. Errors (Cause::kCannotAnswer): neither a group with
/// columns nor a dataset of one or two dimensions, or too long; as ColumnsOfMatrix. Memory: the
/// table.
[[nodiscard]] Result<NumberTable> ReadHdf5Table(const Hdf5Id& file, const std::string& name,
                                                const std::string& where,
                                                const ImportOptions& options);

}  // namespace haptometer::trial
