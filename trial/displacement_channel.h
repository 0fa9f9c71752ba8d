#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>

#include "trial/record.h"

namespace haptometer::trial {

/// The number of the first displacement channel in metres: the one that a recording is about.
/// Nothing where there is none. `source` is what has channels: a record, or a trial's header.
template <typename Source>
[[nodiscard]] std::optional<std::size_t> DisplacementChannel(const Source& source) {
  const auto found = std::ranges::find_if(source.channels, [](const auto& channel) {
    return channel.role == ChannelRole::kDisplacement && channel.unit == "m";
  });
  if (found == source.channels.end()) return std::nullopt;
  return static_cast<std::size_t>(found - source.channels.begin());
}

}  // namespace haptometer::trial
