#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>

#include "trial/trial_format.h"

namespace haptometer::tools {

/// The number of the first displacement channel in metres, which tare, level and checks are about;
/// nothing where there is none.
[[nodiscard]] inline std::optional<std::size_t> DisplacementChannel(
    const trial::TrialHeader& header) {
  const auto found = std::ranges::find_if(header.channels, [](const trial::ChannelFormat& channel) {
    return channel.role == trial::ChannelRole::kDisplacement && channel.unit == "m";
  });
  if (found == header.channels.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header.channels.begin());
}

/// The value of `sample` in the channel's unit: raw * scale + offset.
[[nodiscard]] inline double ValueOf(const trial::ChannelFormat& channel,
                                    const trial::Sample& sample) {
  return sample.raw.Number(channel.encoding) * channel.scale + channel.offset;
}

}  // namespace haptometer::tools
