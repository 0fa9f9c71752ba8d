#pragma once

#include <string_view>

namespace haptometer::tools {

/// What a latency is to a user (Lindsay 2013, p. 4): from 25 ms on it costs errors, from 50 ms on
/// it is perceived.
[[nodiscard]] std::string_view LatencyVerdict(double latency_s);

}  // namespace haptometer::tools
