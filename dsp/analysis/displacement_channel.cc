#include "dsp/analysis/displacement_channel.h"

#include <fmt/core.h>

namespace haptometer::dsp {

Result<std::size_t> DisplacementChannel(const trial::Record& head) {
  const trial::Channel* first = head.Find(trial::ChannelRole::kDisplacement);
  if (first == nullptr) {
    return CannotAnswer("", "holds no displacement channel", "name one displacement_m");
  }
  for (std::size_t k = 0; k < head.channels.size(); ++k) {
    const trial::Channel& channel = head.channels[k];
    if (channel.role == trial::ChannelRole::kDisplacement && channel.unit == "m") return k;
  }
  return CannotAnswer("", fmt::format("its displacement has the unit '{}'", first->unit),
                      "convert it to metres");
}

}  // namespace haptometer::dsp
