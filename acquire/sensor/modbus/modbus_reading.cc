#include "acquire/sensor/modbus/modbus_reading.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "acquire/protocol/value.h"

namespace haptometer::acquire {
namespace {

using trial::SampleStatus;

trial::Encoding EncodingOf(RegisterType type) {
  switch (type) {
    case RegisterType::kF32:
      return trial::Encoding::kF32;
    case RegisterType::kU32:  // beyond the counts of i32; exact
      return trial::Encoding::kF64;
    default:
      return trial::Encoding::kI32;
  }
}

trial::RawValue RawOf(std::uint32_t bits, RegisterType type) {
  switch (EncodingOf(type)) {
    case trial::Encoding::kF32:
      return trial::RawValue::Bits(bits);
    case trial::Encoding::kF64:
      return trial::RawValue::F64(NumberOf(bits, type));
    case trial::Encoding::kI32:
      break;
  }
  return trial::RawValue::Counts(static_cast<std::int32_t>(NumberOf(bits, type)));
}

std::size_t Offset(const SensorProfile& profile, int address) {
  return static_cast<std::size_t>(address - profile.address);
}

SampleStatus StatusOf(const SensorProfile& profile, std::string_view registers,
                      std::uint32_t bits) {
  if (profile.status_address) {
    const std::uint16_t flags = RegisterAt(registers, Offset(profile, *profile.status_address));
    if ((flags & profile.status_mask) != 0) {
      return profile.status_meaning == StatusMeaning::kInvalid ? SampleStatus::kInvalid
                                                               : SampleStatus::kDeviceError;
    }
  }
  const double number = NumberOf(bits, profile.type);
  const bool is_listed =
      std::ranges::find(profile.invalid_bits, bits) != profile.invalid_bits.end();
  if (!std::isfinite(number) || is_listed) return SampleStatus::kInvalid;
  if (profile.least_number && number < *profile.least_number) return SampleStatus::kUnder;
  if (profile.most_number && number > *profile.most_number) return SampleStatus::kOver;
  return SampleStatus::kOk;
}

}  // namespace

trial::ChannelFormat ChannelOf(const SensorProfile& profile, double register_scale) {
  trial::ChannelFormat channel;
  channel.name = "displacement";
  channel.role = trial::ChannelRole::kDisplacement;
  channel.unit = "m";
  channel.encoding = EncodingOf(profile.type);
  channel.scale = profile.scale * register_scale * profile.unit_m;
  channel.offset = profile.offset * profile.unit_m;
  const bool is_whole = profile.type != RegisterType::kF32;
  channel.resolution = profile.resolution_m.value_or(is_whole ? std::abs(channel.scale) : 0);
  // the ends, whichever way the scale goes
  const auto end_m = [&](const std::optional<double>& number, double otherwise) {
    return number ? *number * channel.scale + channel.offset : otherwise;
  };
  const double least_m = end_m(profile.least_number, channel.range_min);
  const double most_m = end_m(profile.most_number, channel.range_max);
  if (channel.scale > 0) {
    channel.range_min = profile.range_min_m.value_or(least_m);
    channel.range_max = profile.range_max_m.value_or(most_m);
  }
  return channel;
}

trial::Sample DecodeReading(const SensorProfile& profile, std::string_view registers) {
  std::array<std::uint16_t, 2> words{};
  const std::size_t count = RegistersOf(profile.type);
  const std::size_t first = Offset(profile, profile.value_address);
  for (std::size_t i = 0; i < count; ++i) words[i] = RegisterAt(registers, first + i);
  const std::uint32_t bits = BitsFrom(std::span(words).first(count), profile.type, profile.order);
  return {RawOf(bits, profile.type), StatusOf(profile, registers, bits)};
}

trial::RawValue NoValue(RegisterType type) {
  switch (EncodingOf(type)) {
    case trial::Encoding::kF32:
      return trial::RawValue::F32(std::numeric_limits<float>::quiet_NaN());
    case trial::Encoding::kF64:
      return trial::RawValue::F64(std::numeric_limits<double>::quiet_NaN());
    case trial::Encoding::kI32:
      break;
  }
  return trial::RawValue::Counts(kNoCounts);
}

std::string_view TimestampOf(const SensorProfile& profile, std::string_view registers) {
  return registers.substr(2 * Offset(profile, *profile.timestamp_address),
                          2 * static_cast<std::size_t>(profile.timestamp_count));
}

}  // namespace haptometer::acquire
