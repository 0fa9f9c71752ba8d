#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>

#include "trial/record.h"
#include "trial/trial_format.h"

namespace haptometer::tools {

/// The number of the first displacement channel in metres, which tare, level and checks are about;
/// nothing where there is none. `source` is what has channels: a trial's header, or its record.
template <typename Source>
[[nodiscard]] std::optional<std::size_t> DisplacementChannel(const Source& source) {
  const auto found = std::ranges::find_if(source.channels, [](const auto& channel) {
    return channel.role == trial::ChannelRole::kDisplacement && channel.unit == "m";
  });
  if (found == source.channels.end()) return std::nullopt;
  return static_cast<std::size_t>(found - source.channels.begin());
}

/// The value of `sample` in the channel's unit: raw * scale + offset.
[[nodiscard]] inline double ValueOf(const trial::ChannelFormat& channel,
                                    const trial::Sample& sample) {
  return sample.raw.Number(channel.encoding) * channel.scale + channel.offset;
}

}  // namespace haptometer::tools
