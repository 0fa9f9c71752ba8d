#pragma once

#include <cstddef>

#include "base/result.h"
#include "trial/record.h"

namespace haptometer::dsp {

/// Number of the first displacement channel in metres, the one that an analysis is of.
/// Errors (Cause::kCannotAnswer): none is there.
[[nodiscard]] Result<std::size_t> DisplacementChannel(const trial::Record& head);

}  // namespace haptometer::dsp
