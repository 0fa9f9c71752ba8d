#include "trial/record.h"

#include <algorithm>
#include <array>

#include "base/error.h"

namespace haptometer::trial {
namespace {

constexpr std::array<std::string_view, kSampleStatusCount> kStatusNames{
    "ok", "repeated", "over", "under", "invalid", "device_error", "late", "clipped", "bad_frame"};

constexpr std::array<std::string_view, 5> kRoleNames{"displacement", "voltage", "current",
                                                     "trigger", "other"};

// the enumerator whose place in `names` holds `name`
template <typename Enum, std::size_t kCount>
std::optional<Enum> FromName(const std::array<std::string_view, kCount>& names,
                             std::string_view name) {
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) return std::nullopt;
  return static_cast<Enum>(found - names.begin());
}

}  // namespace

std::string_view Name(SampleStatus status) {
  const auto index = static_cast<std::size_t>(status);
  HAPTOMETER_CHECK(index < kStatusNames.size(), "status {}", index);
  return kStatusNames[index];
}

std::optional<SampleStatus> SampleStatusFromName(std::string_view name) {
  return FromName<SampleStatus>(kStatusNames, name);
}

std::string_view Name(ChannelRole role) { return kRoleNames[static_cast<std::size_t>(role)]; }

const Channel* Record::Find(ChannelRole role) const {
  const auto found = std::ranges::find(channels, role, &Channel::role);
  return found == channels.end() ? nullptr : &*found;
}

double TimeOf(const Record& record, std::size_t row) {
  HAPTOMETER_CHECK(row < record.rows && !record.stretches.empty(), "row {} of {}", row,
                   record.rows);
  const auto after = std::ranges::upper_bound(record.stretches, row, {}, &Stretch::first_row);
  const Stretch& stretch = *std::prev(after);
  return stretch.start_s + static_cast<double>(row - stretch.first_row) / stretch.rate_hz;
}

}  // namespace haptometer::trial
