#pragma once

#include <cstddef>

#include "base/result.h"
#include "trial/record.h"

namespace haptometer::dsp {

/// The number of the first displacement channel in metres. Errors (Cause::kCannotAnswer): there is
/// none.
[[nodiscard]] Result<std::size_t> DisplacementChannel(const trial::Record& head);

}  // namespace haptometer::dsp
