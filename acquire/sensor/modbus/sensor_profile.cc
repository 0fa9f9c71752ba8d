#include "acquire/sensor/modbus/sensor_profile.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "acquire/protocol/wire.h"
#include "base/text.h"

namespace haptometer::acquire {
namespace {

// libmodbus 3.1.6, modbus-rtu.c, as far as Linux has them
constexpr std::array kBauds{110,     300,     600,     1200,    2400,    4800,    9600,    19200,
                            38400,   57600,   115200,  230400,  460800,  500000,  576000,  921600,
                            1000000, 1152000, 1500000, 2000000, 2500000, 3000000, 3500000, 4000000};

constexpr MonotonicNs kLongestWaitNs = 60 * kNsPerS;
constexpr int kMostAddresses = 65536;

// whether `count` registers from `address` are among those that one request reads
bool IsRead(const SensorProfile& profile, int address, int count) {
  return address >= profile.address && address + count <= profile.address + profile.count;
}

// addresses exist, and one request can ask for them
bool CanBeAsked(const SensorProfile& profile, int address, int count) {
  return address >= profile.address_base && count >= 1 && count <= kMostModbusRegisters &&
         address - profile.address_base + count <= kMostAddresses;
}

std::string WrongWire(const SensorProfile& profile) {
  if (std::ranges::find(kBauds, profile.wire.baud) == kBauds.end()) {
    return fmt::format("baud: {} cannot be set; have {}", profile.wire.baud,
                       fmt::join(kBauds, ", "));
  }
  if (profile.wire.stop_bits != 1 && profile.wire.stop_bits != 2)
    return "stop_bits: must be 1 or 2";
  const bool whole_device = profile.transport == ModbusFraming::kTcp &&
                            (profile.wire.slave == 0 || profile.wire.slave == 255);
  if (!whole_device && (profile.wire.slave < 1 || profile.wire.slave > 247)) {
    return "slave: must be 1 to 247, over TCP also 0 or 255";
  }
  const auto waits = {profile.response_timeout_ns, profile.longest_reply_ns};
  if (std::ranges::any_of(waits, [](MonotonicNs ns) { return ns <= 0 || ns > kLongestWaitNs; })) {
    return "response_timeout_s: waits must be above 0 and at most 60 s";
  }
  if (profile.longest_reply_ns < profile.response_timeout_ns) {
    return "longest_reply_s: must not be below response_timeout_s";
  }
  if (profile.least_gap_ns < 0 || profile.least_gap_ns > kLongestWaitNs) {
    return "least_gap_s: must be 0 to 60 s";
  }
  return {};
}

std::string WrongRequest(const SensorProfile& profile) {
  if (profile.function != 3 && profile.function != 4) return "function: must be 3 or 4";
  if (profile.address_base != 0 && profile.address_base != 1) return "address_base: must be 0 or 1";
  if (!CanBeAsked(profile, profile.address, profile.count)) {
    return "count: 1 to 125 registers can be read, within address_base to address_base + 65535";
  }
  if (profile.check_address.has_value() != profile.check_count.has_value()) {
    return "check_address: needs check_count, and check_count needs it";
  }
  if (profile.check_count) {
    if (!CanBeAsked(profile, *profile.check_address, *profile.check_count)) {
      return "check_count: 1 to 125 registers can be read";
    }
    if (*profile.check_count == profile.count) {
      return "check_count: must differ from count, or a late reply cannot be told from it";
    }
  }
  return {};
}

std::string WrongValue(const SensorProfile& profile) {
  const auto registers = static_cast<int>(RegistersOf(profile.type));
  if (!IsRead(profile, profile.value_address, registers)) {
    return "[value] address: must lie within the registers that are read";
  }
  const auto is_finite = [](double number) { return std::isfinite(number); };
  if (!is_finite(profile.scale) || profile.scale == 0) return "scale: must be a number, not 0";
  if (!is_finite(profile.offset)) return "offset: must be finite";
  if (!(is_finite(profile.unit_m) && profile.unit_m > 0)) return "unit: must be a length";
  if (profile.scale_address && !CanBeAsked(profile, *profile.scale_address, 1)) {
    return "scale_address: there is no such register";
  }
  const bool narrow = registers == 1;
  if (std::ranges::any_of(profile.invalid_bits,
                          [&](std::uint32_t bits) { return narrow && bits > 0xFFFF; })) {
    return "raw: does not fit the value's type";
  }
  if (profile.least_number && profile.most_number &&
      !(*profile.least_number < *profile.most_number)) {
    return "least: must be below most";
  }
  return {};
}

std::string WrongCompanions(const SensorProfile& profile) {
  if (profile.status_address && !IsRead(profile, *profile.status_address, 1)) {
    return "[status] address: must lie within the registers that are read";
  }
  if (profile.status_address && profile.status_mask == 0) return "mask: must not be 0";
  if (profile.timestamp_address &&
      (profile.timestamp_count < 1 ||
       !IsRead(profile, *profile.timestamp_address, profile.timestamp_count))) {
    return "[timestamp] address: must lie within the registers that are read";
  }
  if (profile.fastest_rate_hz && !(*profile.fastest_rate_hz >= 1e-3)) {
    return "fastest_rate_hz: must be above 0";
  }
  return {};
}

}  // namespace

std::string WhatIsWrong(const SensorProfile& profile) {
  if (profile.name.empty()) return "name: must not be empty";
  for (const auto check : {WrongWire, WrongRequest, WrongValue, WrongCompanions}) {
    if (std::string wrong = check(profile); !wrong.empty()) return wrong;
  }
  return {};
}

std::span<const int> ModbusBauds() { return kBauds; }

Result<SensorProfile> FindProfile(const std::string& name_or_file) {
  std::vector<std::string> names;
  for (const SensorProfile& profile : BuiltInProfiles()) {
    if (profile.name == name_or_file) return profile;
    names.push_back(profile.name);
  }
  std::error_code error;
  if (std::filesystem::exists(name_or_file, error)) return ReadProfileFile(name_or_file);
  const std::string nearest = Nearest(name_or_file, names);
  return Usage(
      "--profile", fmt::format("'{}' is neither a built-in profile nor a file", name_or_file),
      nearest.empty() ? fmt::format("give a TOML file or one of {}", fmt::join(names, ", "))
                      : fmt::format("did you mean {}?", nearest));
}

ReadRequest ReadingRequest(const SensorProfile& profile) {
  return {.transaction = 0,
          .unit = static_cast<std::uint8_t>(profile.wire.slave),
          .function = static_cast<std::uint8_t>(profile.function),
          .address = static_cast<std::uint16_t>(profile.address - profile.address_base),
          .count = static_cast<std::uint16_t>(profile.count)};
}

ReadRequest CheckRequest(const SensorProfile& profile) {
  ReadRequest request = ReadingRequest(profile);
  if (profile.check_address) {
    request.address = static_cast<std::uint16_t>(*profile.check_address - profile.address_base);
    request.count = static_cast<std::uint16_t>(*profile.check_count);
  } else {
    // one register fewer, or two for one; refused or not, the reply differs from a reading's
    request.count = profile.count > 1 ? static_cast<std::uint16_t>(profile.count - 1) : 2;
  }
  return request;
}

MonotonicNs RtuExchangeNs(const SensorProfile& profile) {
  constexpr std::size_t kRequestBytes = 8;
  const std::size_t characters =
      kRequestBytes + ReplyBytes(ModbusFraming::kRtu, static_cast<std::size_t>(profile.count));
  return WireTimeNs(characters, profile.wire.baud, BitsPerCharacter(profile.wire));
}

MonotonicNs RtuPeriodNs(const SensorProfile& profile) {
  const MonotonicNs silent_ns = SilentIntervalNs(profile.wire);
  return RtuExchangeNs(profile) + silent_ns + std::max(silent_ns, profile.least_gap_ns);
}

double HighestRateHz(const SensorProfile& profile) {
  const double wire_hz = 1.0 / SecondsFromNs(RtuPeriodNs(profile));
  return std::min(wire_hz, profile.fastest_rate_hz.value_or(wire_hz));
}

std::vector<std::string> WireRemarks(const SensorProfile& profile) {
  std::vector<std::string> remarks;
  const double highest_hz = HighestRateHz(profile);
  const double wire_hz = 1.0 / SecondsFromNs(RtuPeriodNs(profile));
  const double sensor_hz = profile.fastest_rate_hz.value_or(wire_hz);
  if (profile.transport == ModbusFraming::kRtu) {
    remarks.push_back(fmt::format(
        "{} at {} baud: {} registers take {:.2f} ms on the wire, at most {:.0f} readings/s{}: "
        "motion up to {:.1f} Hz can be observed (rate / 2.56)",
        profile.name, profile.wire.baud, profile.count, 1e3 / wire_hz, wire_hz,
        sensor_hz < wire_hz ? fmt::format(", {:.0f} of them new", sensor_hz) : "",
        HighestObservableHz(highest_hz)));
    remarks.emplace_back(
        "20-500 Hz vibration cannot be observed over Modbus RTU at any baud rate (two silent "
        "intervals of 1.75 ms leave 286 readings/s, 1280 are needed): use the sensor's own stream "
        "(--sensor stream) or its analog output with a DAQ");
  } else if (profile.fastest_rate_hz) {
    remarks.push_back(fmt::format(
        "{} measures {:.0f} times a second: motion up to {:.1f} Hz can be observed (rate / 2.56)",
        profile.name, sensor_hz, HighestObservableHz(sensor_hz)));
  } else {
    remarks.push_back(fmt::format(
        "how often {} measures is not known: motion can be observed up to its rate / 2.56, and "
        "the rate of replies says nothing of it",
        profile.name));
  }
  return remarks;
}

}  // namespace haptometer::acquire
