#pragma once

#include <optional>
#include <string>

#include "base/quantity.h"
#include "base/result.h"
#include "tools/cli/options.h"
#include "trial/import/import_options.h"

namespace haptometer::cli {

/// What the command line says of a foreign table.
struct ImportWords {
  std::string columns;
  std::optional<Quantity> rate_hz;
  std::optional<Quantity> scale_m;
};

/// Declares --columns, --rate and --scale, shown by --help-all, for any verb that reads recordings.
void DeclareImport(Options* options, ImportWords* words);

/// Errors (Cause::kUsage): a rate or scale that is not above 0, an empty name among the columns.
[[nodiscard]] Result<trial::ImportOptions> ImportOf(const ImportWords& words);

}  // namespace haptometer::cli
