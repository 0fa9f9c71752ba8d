#include "trial/record.h"

#include "base/error.h"
#include "base/names.h"

namespace haptometer::trial {
namespace {

constexpr Names<SampleStatus, kSampleStatusCount> kStatusNames{
    {"ok", "repeated", "over", "under", "invalid", "device_error", "late", "clipped", "bad_frame"}};
constexpr Names<ChannelRole, 5> kRoleNames{
    {"displacement", "voltage", "current", "trigger", "other"}};

}  // namespace

std::string_view Name(SampleStatus status) { return kStatusNames.Of(status); }

std::optional<SampleStatus> SampleStatusFromName(std::string_view name) {
  return kStatusNames.From(name);
}

std::string_view Name(ChannelRole role) { return kRoleNames.Of(role); }

const Channel* Record::Find(ChannelRole role) const {
  const auto found = std::ranges::find(channels, role, &Channel::role);
  return found == channels.end() ? nullptr : &*found;
}

double TimeOf(const Record& record, std::size_t row) {
  HAPTOMETER_CHECK(row < record.rows && !record.stretches.empty(), "row {} of {}", row,
                   record.rows);
  // t = start_s + (row - first_row) / rate_hz of the last segment that begins at or before the row
  const auto after = std::ranges::upper_bound(record.stretches, row, {}, &Stretch::first_row);
  const Stretch& stretch = *std::prev(after);
  return stretch.start_s + static_cast<double>(row - stretch.first_row) / stretch.rate_hz;
}

}  // namespace haptometer::trial
