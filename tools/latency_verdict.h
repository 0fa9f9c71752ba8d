#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "sim/skin/skin_rise.h"

namespace haptometer::tools {

/// What a latency is to a user (Lindsay 2013, p. 4): from 25 ms on it costs errors, from 50 ms on
/// it is perceived.
[[nodiscard]] std::string_view LatencyVerdict(double latency_s);

/// The same of a simulated latency, if it is so from an uncertainty below to one above it.
[[nodiscard]] std::string_view LatencyVerdict(const sim::SkinRise& rise);

/// "2.935 ms, to 0.67 ms", or "below 2.495 ms" where the latency is not above its uncertainty.
[[nodiscard]] std::string LatencyText(const sim::SkinRise& rise);

/// What a latency that is not above its uncertainty is below; nothing of one that is.
[[nodiscard]] std::optional<double> LatencyBelowS(const sim::SkinRise& rise);

}  // namespace haptometer::tools
