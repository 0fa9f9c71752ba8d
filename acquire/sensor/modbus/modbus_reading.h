#pragma once

#include <string_view>

#include "acquire/sensor/modbus/sensor_profile.h"
#include "trial/trial_format.h"

/// What the registers of a Modbus sensor mean by its profile. `registers` are those of one reading,
/// as many as profile.count, two bytes each.
namespace haptometer::acquire {

/// The channel that a trial keeps of it: numbers as sent (f64 for u32, which i32 does not hold).
/// `register_scale` is the number in the profile's scale register, else 1.
[[nodiscard]] trial::ChannelFormat ChannelOf(const SensorProfile& profile, double register_scale);

/// The number as sent, with what profile and status register say of it.
[[nodiscard]] trial::Sample DecodeReading(const SensorProfile& profile, std::string_view registers);

/// What stands in for a number where none came.
[[nodiscard]] trial::RawValue NoValue(RegisterType type);

/// The timestamp registers; the profile has some.
[[nodiscard]] std::string_view TimestampOf(const SensorProfile& profile,
                                           std::string_view registers);

}  // namespace haptometer::acquire
