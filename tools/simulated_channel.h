#pragma once

#include "trial/record.h"
#include "trial/trial_format.h"

namespace haptometer::tools {

/// How a trial keeps a simulated channel: one that is rounded to steps as whole counts of them, any
/// other as doubles.
[[nodiscard]] trial::ChannelFormat FormatOf(const trial::Channel& channel);

/// `value` (in the channel's unit) as `format` keeps it; 0 counts for NaN, which is no measurement.
[[nodiscard]] trial::RawValue RawOf(const trial::ChannelFormat& format, double value);

}  // namespace haptometer::tools
