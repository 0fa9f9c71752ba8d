#pragma once

#include <optional>
#include <string>

#include "acquire/capability.h"
#include "base/error.h"
#include "base/quantity.h"

namespace haptometer::tools {

/// What is asked of the sensors, from `--band` and `--resolution`. Errors (Cause::kUsage): a band
/// that is none, a resolution that is not above 0.
[[nodiscard]] Result<acquire::CapabilityQuestion> ReadCapabilityQuestion(
    const std::string& band, const std::optional<Quantity>& resolution_m);

/// What `acquire --list-sensors` prints: each known sensor, whether it can answer, and why.
[[nodiscard]] std::string SensorListText(const acquire::CapabilityQuestion& question);

/// The same as a JSON document (docs/commands.md), with a line's end.
[[nodiscard]] std::string SensorListJson(const acquire::CapabilityQuestion& question);

}  // namespace haptometer::tools
