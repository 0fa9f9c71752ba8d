// A sensor profile from its TOML file; docs/sensors.md has the keys with an example.
#include <cmath>
#include <limits>
#include <utility>

#include "acquire/sensor/modbus/sensor_profile.h"
#include "base/toml.h"

namespace haptometer::acquire {
namespace {

// an integer key that fits an int; its own limits are checked with the whole profile
void ReadInt(TomlTable& table, std::string_view key, int& value) {
  const auto number = table.Integer(key);
  if (!number) return;
  if (!std::in_range<int>(*number)) return table.Refuse(key, "is far too large");
  value = static_cast<int>(*number);
}

void ReadInt(TomlTable& table, std::string_view key, std::optional<int>& value) {
  int number = 0;
  if (!table.Has(key)) return;
  ReadInt(table, key, number);
  value = number;
}

void ReadTime(TomlTable& table, std::string_view key, MonotonicNs& ns) {
  const auto seconds = table.Number(key, Dimension::kTime);
  if (!seconds) return;
  if (!(*seconds >= 0 && *seconds <= 60)) return table.Refuse(key, "must be 0 to 60 s");
  ns = NsFromSeconds(*seconds);
}

void ReadWire(TomlTable& table, SensorProfile& profile) {
  const auto transport = table.Choice("transport", {"rtu", "tcp"});
  if (transport == "tcp") profile.transport = ModbusFraming::kTcp;
  ReadInt(table, "baud", profile.wire.baud);
  ReadInt(table, "stop_bits", profile.wire.stop_bits);
  const auto parity = table.Choice("parity", {"none", "even", "odd"});
  if (parity == "none") profile.wire.parity = Parity::kNone;
  if (parity == "odd") profile.wire.parity = Parity::kOdd;
  ReadInt(table, "slave", profile.wire.slave);
  ReadTime(table, "least_gap_s", profile.least_gap_ns);
  ReadTime(table, "response_timeout_s", profile.response_timeout_ns);
  ReadTime(table, "longest_reply_s", profile.longest_reply_ns);
}

void ReadRequestKeys(TomlTable& table, SensorProfile& profile) {
  ReadInt(table, "function", profile.function);
  ReadInt(table, "address_base", profile.address_base);
  if (!table.Has("address"))
    table.Refuse("address", "is missing", "add the first register to read");
  ReadInt(table, "address", profile.address);
  ReadInt(table, "count", profile.count);
  profile.is_exact = table.Flag("exact").value_or(false);
  ReadInt(table, "check_address", profile.check_address);
  ReadInt(table, "check_count", profile.check_count);
  profile.value_address = profile.address;
}

void ReadValue(TomlTable& table, SensorProfile& profile) {
  ReadInt(table, "address", profile.value_address);
  const auto type = table.Choice("type", {"u16", "i16", "u32", "i32", "f32"});
  if (type) profile.type = *RegisterTypeFromName(*type);
  const auto order = table.Choice("order", {"ABCD", "CDAB", "BADC", "DCBA"});
  if (order) profile.order = *WordOrderFromName(*order);
  const auto unit = table.Choice("unit", {"m", "cm", "mm", "um", "nm"});
  if (!unit && !table.Has("unit")) {
    table.Refuse("unit", "is missing", "add the unit of the numbers: m, cm, mm, um or nm");
  }
  if (unit) profile.unit_m = ParseQuantity("1" + *unit, Dimension::kLength, "unit")->value;
  profile.scale = table.Number("scale", Dimension::kNone).value_or(profile.scale);
  profile.offset = table.Number("offset", Dimension::kNone).value_or(profile.offset);
  ReadInt(table, "scale_address", profile.scale_address);
}

void ReadInvalid(TomlTable& table, SensorProfile& profile) {
  for (const long long number : table.Integers("raw")) {
    // negative numbers are written as people read them, in the value's own width
    const bool narrow = RegistersOf(profile.type) == 1;
    const long long least = narrow ? -32768 : std::numeric_limits<std::int32_t>::min();
    const long long most = narrow ? 0xFFFF : std::numeric_limits<std::uint32_t>::max();
    if (number < least || number > most) {
      return table.Refuse("raw", "does not fit the value's type");
    }
    const auto bits = static_cast<std::uint32_t>(number);
    profile.invalid_bits.push_back(narrow ? bits & 0xFFFFU : bits);
  }
  profile.least_number = table.Number("least", Dimension::kNone);
  profile.most_number = table.Number("most", Dimension::kNone);
}

void ReadStatus(TomlTable& table, SensorProfile& profile) {
  int mask = 0;
  profile.status_address = 0;
  ReadInt(table, "address", profile.status_address);
  ReadInt(table, "mask", mask);
  if (mask < 1 || mask > 0xFFFF) table.Refuse("mask", "must be 1 to 0xFFFF");
  profile.status_mask = static_cast<std::uint16_t>(mask);
  const auto means = table.Choice("means", {"invalid", "device_error"});
  if (means == "device_error") profile.status_meaning = StatusMeaning::kDeviceError;
}

void ReadTimestamp(TomlTable& table, SensorProfile& profile) {
  profile.timestamp_address = 0;
  profile.timestamp_count = 1;
  ReadInt(table, "address", profile.timestamp_address);
  ReadInt(table, "count", profile.timestamp_count);
}

void ReadAbilities(TomlTable& table, SensorProfile& profile) {
  profile.range_min_m = table.Number("range_min_m", Dimension::kLength);
  profile.range_max_m = table.Number("range_max_m", Dimension::kLength);
  profile.resolution_m = table.Number("resolution_m", Dimension::kLength);
  profile.noise_rms_m = table.Number("noise_rms_m", Dimension::kLength);
  profile.fastest_rate_hz = table.Number("fastest_rate_hz", Dimension::kFrequency);
}

void ReadTables(TomlTable& root, SensorProfile& profile) {
  const auto required = [&](std::string_view key) {
    TomlTable* table = root.Table(key);
    if (table == nullptr && !root.Has(key)) root.Refuse(key, "is missing", "add the table");
    return table;
  };
  if (TomlTable* table = root.Table("wire")) ReadWire(*table, profile);
  if (TomlTable* table = required("request")) ReadRequestKeys(*table, profile);
  if (TomlTable* table = required("value")) ReadValue(*table, profile);
  if (TomlTable* table = root.Table("invalid")) ReadInvalid(*table, profile);
  if (TomlTable* table = root.Table("status")) ReadStatus(*table, profile);
  if (TomlTable* table = root.Table("timestamp")) ReadTimestamp(*table, profile);
  if (TomlTable* table = root.Table("abilities")) ReadAbilities(*table, profile);
}

Result<SensorProfile> ReadProfile(TomlTable root) {
  SensorProfile profile;
  if (!root.Has("name")) root.Refuse("name", "is missing", "add the sensor's name");
  profile.name = root.Text("name").value_or("");
  profile.maker = root.Text("maker").value_or("");
  profile.model = root.Text("model").value_or("");
  profile.manual = root.Text("manual").value_or("");
  profile.advice = root.Text("advice").value_or("");
  ReadTables(root, profile);
  if (auto done = root.Finish(); !done) return std::unexpected(done.error());
  if (const std::string wrong = WhatIsWrong(profile); !wrong.empty()) {
    return Usage(root.where(), wrong, "docs/sensors.md describes the keys");
  }
  return profile;
}

}  // namespace

Result<SensorProfile> ReadProfileFile(const std::string& path) {
  auto root = TomlTable::ParseFile(path);
  if (!root) return std::unexpected(root.error());
  return ReadProfile(std::move(*root));
}

Result<SensorProfile> ReadProfileText(std::string_view text, std::string where) {
  auto root = TomlTable::ParseText(text, std::move(where));
  if (!root) return std::unexpected(root.error());
  return ReadProfile(std::move(*root));
}

}  // namespace haptometer::acquire
