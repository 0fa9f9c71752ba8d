#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "trial/record.h"

namespace haptometer::dsp {

/// A displacement record of one clocked stretch, every value measured.
inline trial::Record RecordOf(std::vector<double> values_m, double rate_hz) {
  trial::Record record;
  record.rows = values_m.size();
  record.stretches = {{0, record.rows, 0, rate_hz, 0}};
  trial::Channel channel;
  channel.name = "displacement";
  channel.role = trial::ChannelRole::kDisplacement;
  channel.unit = "m";
  channel.statuses.assign(record.rows, trial::SampleStatus::kOk);
  channel.values = std::move(values_m);
  record.channels.push_back(std::move(channel));
  return record;
}

}  // namespace haptometer::dsp
