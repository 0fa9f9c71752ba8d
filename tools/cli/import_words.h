#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/error.h"
#include "base/quantity.h"
#include "tools/cli/options.h"
#include "trial/import/import_options.h"

namespace haptometer::cli {

/// What the command line says of a foreign table.
struct ImportWords {
  std::string columns;
  std::optional<Quantity> rate_hz;
  std::optional<Quantity> scale_m;
  std::optional<Quantity> scale_v;
  std::string format;
  std::string channel;
  std::optional<std::int64_t> segment;
};

/// What a verb reads of a table, which --scale is then about.
enum class Scaled : std::uint8_t { kDisplacement, kVoltage };

/// Declares --columns, --rate, --scale, --format, --channel and --segment, shown by --help-all, for
/// any verb that reads recordings. A verb that has a --format of its own says so by `has_format`.
void DeclareImport(Options* options, ImportWords* words, Scaled scaled = Scaled::kDisplacement,
                   bool has_format = false);

/// Errors (Cause::kUsage): a rate that is not above 0, a scale of 0, an empty name among the
/// columns, a format that is not known.
[[nodiscard]] Result<trial::ImportOptions> ImportOf(const ImportWords& words);

}  // namespace haptometer::cli
