#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/findings.h"
#include "acquire/protocol/modbus.h"
#include "base/clock.h"
#include "base/error.h"

namespace haptometer::acquire {

/// What a set status bit says of the reading.
enum class StatusMeaning : std::uint8_t { kInvalid, kDeviceError };

/// Everything that makes one Modbus distance sensor differ from another, as a file says it
/// (docs/reference/sensors.md, "Modbus"). Built-in sensors are written in the same form.
///
/// Addresses are as the maker prints them; `address_base` is the number of the first register in
/// the maker's count (0, or 1 where the manual counts from one), which is taken off on the wire.
struct SensorProfile {
  std::string name{};    ///< by which --profile knows it: "baumer-om20"
  std::string maker{};   ///< "Baumer"
  std::string model{};   ///< "OM20/OM30 RS485"
  std::string manual{};  ///< where this is from
  std::string advice{};  ///< what to check when nothing answers; may be empty

  // what it can do, where the maker says so
  std::optional<double> range_min_m{};
  std::optional<double> range_max_m{};
  std::optional<double> resolution_m{};
  std::optional<double> noise_rms_m{};
  std::optional<double> fastest_rate_hz{};  ///< new readings a second, whatever the wire

  // the wire
  ModbusFraming transport = ModbusFraming::kRtu;
  ModbusWire wire{};
  MonotonicNs least_gap_ns = 0;  ///< from a reply to the next request; RTU: the silent interval
  MonotonicNs response_timeout_ns = kNsPerS / 2;  ///< then the reading is late
  MonotonicNs longest_reply_ns = kNsPerS;         ///< then no reply will come any more

  // the request: what has to be read at once
  int function = 3;  ///< 3: holding registers; 4: input registers
  int address_base = 0;
  int address = 0;
  int count = 1;
  bool is_exact = false;  ///< the sensor refuses other counts within these registers
  // what to ask after a lost reply instead: its reply must have another length
  std::optional<int> check_address{};
  std::optional<int> check_count{};

  // the distance among the registers read: (number * scale + offset) units
  int value_address = 0;
  RegisterType type = RegisterType::kU16;
  WordOrder order = WordOrder::kAbcd;
  double unit_m = 1e-3;
  double scale = 1;
  double offset = 0;
  /// A u16 register, read once at the start, whose number multiplies `scale`.
  std::optional<int> scale_address{};

  // numbers (before scale and offset) that are no distances; NaN never is one
  std::vector<std::uint32_t> invalid_bits{};
  std::optional<double> least_number{};  ///< below: SampleStatus::kUnder
  std::optional<double> most_number{};   ///< above: SampleStatus::kOver

  // a register among those read of which any bit in the mask says that the reading is none
  std::optional<int> status_address{};
  std::uint16_t status_mask = 0;
  StatusMeaning status_meaning = StatusMeaning::kInvalid;

  // registers among those read that change with every new reading
  std::optional<int> timestamp_address{};
  int timestamp_count = 0;
};

/// The sensors that are known without a file.
[[nodiscard]] std::span<const SensorProfile> BuiltInProfiles();

/// Reads a profile file, or its text (`where` stands for its name). Errors: the file's; unknown,
/// missing or impossible keys (Cause::kUsage), named with the nearest known one.
[[nodiscard]] Result<SensorProfile> ReadProfileFile(const std::string& path);
[[nodiscard]] Result<SensorProfile> ReadProfileText(std::string_view text, std::string where);

/// A built-in profile by its name, or else the file of that name. Errors (Cause::kUsage): neither;
/// and those of the file.
[[nodiscard]] Result<SensorProfile> FindProfile(const std::string& name_or_file);

/// What is impossible in a profile, as "KEY: WHAT", or "" where all is well. `FindProfile` and the
/// readers give only profiles that pass.
[[nodiscard]] std::string WhatIsWrong(const SensorProfile& profile);

/// Baud rates that libmodbus sets; it silently takes 9600 for any other.
[[nodiscard]] std::span<const int> ModbusBauds();

/// The request for a reading, and the one that comes after a lost reply: another register count, so
/// that a late reply to the first cannot pass for a reply to the second. Transaction 0.
[[nodiscard]] ReadRequest ReadingRequest(const SensorProfile& profile);
[[nodiscard]] ReadRequest CheckRequest(const SensorProfile& profile);

/// What both frames of a reading need on an RTU wire, in ns: no reply comes sooner.
[[nodiscard]] MonotonicNs RtuExchangeNs(const SensorProfile& profile);

/// Shortest time in ns from request to request on an RTU wire of its own, of a sensor that answers
/// at once: both frames and two silent intervals. 13 registers at 57600 baud 8E1: 11.0 ms.
[[nodiscard]] MonotonicNs RtuPeriodNs(const SensorProfile& profile);

/// Readings a second that wire and sensor allow at most: 1 / RtuPeriodNs, or fewer where the
/// sensor measures more slowly.
[[nodiscard]] double HighestRateHz(const SensorProfile& profile);

/// The same for the user, against the 20-500 Hz band.
[[nodiscard]] Findings FindWireRate(const SensorProfile& profile);

}  // namespace haptometer::acquire
