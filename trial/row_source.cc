#include "trial/row_source.h"

#include <algorithm>

namespace haptometer::trial {
namespace {

// everything but values and statuses; raw times only where they are the readings' own
Record HeadOf(const Record& record) {
  Record head;
  head.rows = record.rows;
  head.timing = record.timing;
  head.stretches = record.stretches;
  head.times_are_known = record.times_are_known;
  if (record.times_are_known) head.raw_times_s = record.raw_times_s;
  head.metadata = record.metadata;
  head.channels.reserve(record.channels.size());
  for (const Channel& channel : record.channels) {
    head.channels.push_back({.name = channel.name,
                             .role = channel.role,
                             .unit = channel.unit,
                             .range_min = channel.range_min,
                             .range_max = channel.range_max,
                             .resolution = channel.resolution});
  }
  return head;
}

}  // namespace

// one channel after the other, since a source is read by channel
Result<Record> ReadAllRows(const RowSource& source) {
  Record record = source.head();
  for (std::size_t c = 0; c < record.channels.size(); ++c) {
    Channel& channel = record.channels[c];
    channel.values.resize(record.rows);
    channel.statuses.resize(record.rows);
    HAPTOMETER_TRY(source.Read(c, 0, channel.values, channel.statuses));
  }
  return record;
}

RecordRows::RecordRows(const Record& record) : record_(record), head_(HeadOf(record)) {}

// copies a range of rows; the spans are within the record by contract
Result<void> RecordRows::Read(std::size_t channel, std::size_t first, std::span<double> values,
                              std::span<SampleStatus> statuses) const {
  HAPTOMETER_CHECK(channel < record_.channels.size() && values.size() == statuses.size() &&
                       first <= record_.rows && values.size() <= record_.rows - first,
                   "channel {}, rows {} + {} of {}", channel, first, values.size(), record_.rows);
  const Channel& column = record_.channels[channel];
  std::ranges::copy(std::span(column.values).subspan(first, values.size()), values.begin());
  std::ranges::copy(std::span(column.statuses).subspan(first, values.size()), statuses.begin());
  return {};
}

}  // namespace haptometer::trial
