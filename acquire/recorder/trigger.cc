#include "acquire/recorder/trigger.h"

#include <fmt/core.h>

#include <algorithm>

#include "base/names.h"

namespace haptometer::acquire {

std::string_view Name(TriggerKind kind) {
  constexpr Names<TriggerKind, 4> kNames{{"above", "below", "rising", "falling"}};
  return kNames.Of(kind);
}

TriggerWatch::TriggerWatch(const TriggerSetup& setup, const trial::TrialHeader& header)
    : setup_(setup) {
  HAPTOMETER_CHECK(setup.channel < header.channels.size(), "channel {} of {}", setup.channel,
                   header.channels.size());
  channel_ = header.channels[setup.channel];
}

bool TriggerWatch::Fires(const Reading& reading) {
  const trial::Sample& sample = reading.samples[setup_.channel];
  // a sample without a measured value neither fires nor changes the edge
  if (!IsMeasurement(sample.status)) return false;
  // value in the unit of the channel: raw * scale + offset
  const double value = sample.raw.Number(channel_.encoding) * channel_.scale + channel_.offset;
  const bool is_upward = setup_.kind == TriggerKind::kAbove || setup_.kind == TriggerKind::kRising;
  const bool is_edge = setup_.kind == TriggerKind::kRising || setup_.kind == TriggerKind::kFalling;
  const bool beyond = is_upward ? value > setup_.threshold : value < setup_.threshold;
  // an edge is a change from not beyond to beyond
  const bool fires = beyond && (!is_edge || (has_last_ && !last_beyond_));
  has_last_ = true;
  last_beyond_ = beyond;
  return fires;
}

std::string TriggerWatch::Text() const {
  const bool is_edge = setup_.kind == TriggerKind::kRising || setup_.kind == TriggerKind::kFalling;
  return fmt::format("{} {}{} {:g} {}", channel_.name, Name(setup_.kind), is_edge ? " through" : "",
                     setup_.threshold, channel_.unit);
}

PreSamples::PreSamples(std::size_t readings, std::size_t channels) : ring_(readings) {
  for (Reading& reading : ring_) reading.samples.resize(channels);
}

// ring of the last readings; the oldest is overwritten
void PreSamples::Keep(const Reading& reading) {
  if (ring_.empty()) return;
  ring_[next_] = reading;
  next_ = (next_ + 1) % ring_.size();
  kept_ = std::min(kept_ + 1, ring_.size());
}

}  // namespace haptometer::acquire
