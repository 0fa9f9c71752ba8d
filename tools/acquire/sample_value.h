#pragma once

#include "trial/trial_format.h"

namespace haptometer::tools {

/// The value of `sample` in the channel's unit: raw * scale + offset.
[[nodiscard]] inline double ValueOf(const trial::ChannelFormat& channel,
                                    const trial::Sample& sample) {
  return sample.raw.Number(channel.encoding) * channel.scale + channel.offset;
}

}  // namespace haptometer::tools
