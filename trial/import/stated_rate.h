#pragma once

#include <optional>
#include <string>

#include "trial/record.h"

namespace haptometer::trial {

/// The rate that a table's words state beside its times: nominal_rate_hz, or the first number with
/// Hz or kHz behind it in a field or note that speaks of a rate or sampling.
[[nodiscard]] std::optional<double> StatedRate(const Metadata& metadata);

/// A sentence where the times of `record` and the rate that it states are a power of a thousand
/// apart, as they are when milliseconds stand in a column of seconds; empty otherwise. The times
/// are taken at their word all the same.
[[nodiscard]] std::string RateRemark(const Record& record);

}  // namespace haptometer::trial
