#include "trial/trial_format.h"

#include <algorithm>
#include <array>

#include "base/error.h"

namespace haptometer::trial {

std::string_view Name(Encoding encoding) {
  constexpr std::array<std::string_view, 3> kNames{"i32", "f32", "f64"};
  return kNames.at(static_cast<std::size_t>(encoding));
}

std::size_t BytesOf(Encoding encoding) { return encoding == Encoding::kF64 ? 8 : 4; }

std::string_view Name(Timing timing) {
  constexpr std::array<std::string_view, 3> kNames{"uniform", "arrival", "polled"};
  return kNames.at(static_cast<std::size_t>(timing));
}

std::string_view Name(EventKind kind) {
  constexpr std::array<std::string_view, 5> kNames{"gap", "reconnect", "remark", "labels",
                                                   "time_base"};
  return kNames.at(static_cast<std::size_t>(kind));
}

Channel ChannelOf(const ChannelFormat& format) {
  return {.name = format.name,
          .role = format.role,
          .unit = format.unit,
          .values = {},
          .statuses = {},
          .range_min = format.range_min,
          .range_max = format.range_max,
          .resolution = format.resolution};
}

TrialHeader HeaderOf(const Record& record) {
  TrialHeader header{.timing = record.timing, .metadata = record.metadata};
  if (!record.stretches.empty()) {
    header.rate_hz = std::ranges::max_element(record.stretches, {}, &Stretch::rows)->rate_hz;
  }
  for (const Channel& channel : record.channels) {
    header.channels.push_back({.name = channel.name,
                               .role = channel.role,
                               .unit = channel.unit,
                               .range_min = channel.range_min,
                               .range_max = channel.range_max,
                               .resolution = channel.resolution});
  }
  return header;
}

double RawValue::Number(Encoding encoding) const {
  const auto low = static_cast<std::uint32_t>(bits_);
  switch (encoding) {
    case Encoding::kI32:
      return std::bit_cast<std::int32_t>(low);
    case Encoding::kF32:
      return static_cast<double>(std::bit_cast<float>(low));
    case Encoding::kF64:
      return std::bit_cast<double>(bits_);
  }
  HAPTOMETER_CHECK(false, "encoding {}", static_cast<int>(encoding));
}

}  // namespace haptometer::trial
