#pragma once

#include <cstddef>

#include "base/error.h"
#include "trial/record.h"

namespace haptometer::dsp {

/// The number of the channel that an analysis is of: trial::DisplacementChannel.
/// Errors (Cause::kCannotAnswer): there is none, or none in metres.
[[nodiscard]] Result<std::size_t> AnalyzedChannel(const trial::Record& head);

}  // namespace haptometer::dsp
