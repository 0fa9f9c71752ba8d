#include "tools/simulated_channel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace haptometer::tools {

trial::ChannelFormat FormatOf(const trial::Channel& channel) {
  trial::ChannelFormat format{.name = channel.name,
                              .role = channel.role,
                              .unit = channel.unit,
                              .range_min = channel.range_min,
                              .range_max = channel.range_max,
                              .resolution = channel.resolution};
  const double largest = std::max(std::abs(channel.range_min), std::abs(channel.range_max));
  if (channel.resolution > 0 &&
      largest / channel.resolution < std::numeric_limits<std::int32_t>::max()) {
    format.encoding = trial::Encoding::kI32;
    format.scale = channel.resolution;
  }
  return format;
}

trial::RawValue RawOf(const trial::ChannelFormat& format, double value) {
  if (format.encoding == trial::Encoding::kF64) return trial::RawValue::F64(value);
  if (std::isnan(value)) return trial::RawValue::Counts(0);
  return trial::RawValue::Counts(static_cast<std::int32_t>(std::lround(value / format.scale)));
}

}  // namespace haptometer::tools
