#include "dsp/analysis/analyzed_channel.h"

#include <fmt/core.h>

#include "trial/record.h"

namespace haptometer::dsp {

Result<std::size_t> AnalyzedChannel(const trial::Record& head) {
  const trial::Channel* first = head.Find(trial::ChannelRole::kDisplacement);
  if (first == nullptr) {
    return CannotAnswer("", "holds no displacement channel", "name one displacement_m");
  }
  if (const auto channel = trial::DisplacementChannel(head)) return *channel;
  return CannotAnswer("", fmt::format("its displacement has the unit '{}'", first->unit),
                      "convert it to metres");
}

}  // namespace haptometer::dsp
