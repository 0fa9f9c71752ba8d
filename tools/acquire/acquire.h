#pragma once

#include <map>
#include <string>

#include "acquire/sensor/sensor.h"
#include "trial/trial_format.h"

namespace haptometer::tools {

/// What a recording begins with: what the sensor (started) says, on which host and when it was made
/// and by which command, and its labels. A replay keeps the host and time of its trial.
[[nodiscard]] trial::TrialHeader RecordingHeader(const acquire::Sensor& sensor, bool is_replay,
                                                 const std::map<std::string, std::string>& labels,
                                                 std::string command_line);

/// What a sensor finds: "amplifier 01: the amplifier holds (peak): ...".
[[nodiscard]] std::string InWords(const acquire::Finding& found);

/// The value of `sample` in the channel's unit: raw * scale + offset.
[[nodiscard]] inline double ValueOf(const trial::ChannelFormat& channel,
                                    const trial::Sample& sample) {
  return sample.raw.Number(channel.encoding) * channel.scale + channel.offset;
}

}  // namespace haptometer::tools
