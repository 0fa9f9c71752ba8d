#include "trial/import/printed_unit.h"

#include <algorithm>
#include <array>
#include <string>

#include "trial/import/printed_number.h"

namespace haptometer::trial {
namespace {

struct UnitName {
  std::string_view name;
  PrintedUnit unit;
};

constexpr std::array<UnitName, 67> kUnits{{{"s", {"s", 1}},
                                           {"sec", {"s", 1}},
                                           {"second", {"s", 1}},
                                           {"seconds", {"s", 1}},
                                           {"sekunden", {"s", 1}},
                                           {"ms", {"s", 1e-3}},
                                           {"msec", {"s", 1e-3}},
                                           {"millisecond", {"s", 1e-3}},
                                           {"milliseconds", {"s", 1e-3}},
                                           {"us", {"s", 1e-6}},
                                           {"\xc2\xb5"
                                            "s",
                                            {"s", 1e-6}},
                                           {"\xce\xbc"
                                            "s",
                                            {"s", 1e-6}},
                                           {"usec", {"s", 1e-6}},
                                           {"microsecond", {"s", 1e-6}},
                                           {"microseconds", {"s", 1e-6}},
                                           {"ns", {"s", 1e-9}},
                                           {"nanosecond", {"s", 1e-9}},
                                           {"nanoseconds", {"s", 1e-9}},
                                           {"ps", {"s", 1e-12}},
                                           {"m", {"m", 1}},
                                           {"meter", {"m", 1}},
                                           {"meters", {"m", 1}},
                                           {"metre", {"m", 1}},
                                           {"metres", {"m", 1}},
                                           {"cm", {"m", 1e-2}},
                                           {"centimeters", {"m", 1e-2}},
                                           {"mm", {"m", 1e-3}},
                                           {"millimeter", {"m", 1e-3}},
                                           {"millimeters", {"m", 1e-3}},
                                           {"millimetre", {"m", 1e-3}},
                                           {"millimetres", {"m", 1e-3}},
                                           {"um", {"m", 1e-6}},
                                           {"\xc2\xb5"
                                            "m",
                                            {"m", 1e-6}},
                                           {"\xce\xbc"
                                            "m",
                                            {"m", 1e-6}},
                                           {"micrometer", {"m", 1e-6}},
                                           {"micrometers", {"m", 1e-6}},
                                           {"micrometre", {"m", 1e-6}},
                                           {"micrometres", {"m", 1e-6}},
                                           {"microns", {"m", 1e-6}},
                                           {"nm", {"m", 1e-9}},
                                           {"nanometer", {"m", 1e-9}},
                                           {"nanometers", {"m", 1e-9}},
                                           {"nanometres", {"m", 1e-9}},
                                           {"v", {"V", 1}},
                                           {"volt", {"V", 1}},
                                           {"volts", {"V", 1}},
                                           {"mv", {"V", 1e-3}},
                                           {"millivolt", {"V", 1e-3}},
                                           {"millivolts", {"V", 1e-3}},
                                           {"uv", {"V", 1e-6}},
                                           {"\xc2\xb5"
                                            "v",
                                            {"V", 1e-6}},
                                           {"\xce\xbc"
                                            "v",
                                            {"V", 1e-6}},
                                           {"microvolts", {"V", 1e-6}},
                                           {"kv", {"V", 1e3}},
                                           {"a", {"A", 1}},
                                           {"amp", {"A", 1}},
                                           {"amps", {"A", 1}},
                                           {"ampere", {"A", 1}},
                                           {"amperes", {"A", 1}},
                                           {"ma", {"A", 1e-3}},
                                           {"milliamp", {"A", 1e-3}},
                                           {"milliamps", {"A", 1e-3}},
                                           {"milliamperes", {"A", 1e-3}},
                                           {"ua", {"A", 1e-6}},
                                           {"\xc2\xb5"
                                            "a",
                                            {"A", 1e-6}},
                                           {"\xce\xbc"
                                            "a",
                                            {"A", 1e-6}},
                                           {"microamps", {"A", 1e-6}}}};

}  // namespace

std::optional<PrintedUnit> FindUnit(std::string_view text) {
  const bool is_mega = text.size() > 1 && text[0] == 'M' && text.size() < 3;
  if (is_mega) return std::nullopt;
  const std::string lower = LowerCase(text);
  const auto found = std::ranges::find(kUnits, lower, &UnitName::name);
  if (found == kUnits.end()) return std::nullopt;
  return found->unit;
}

ChannelRole RoleOfUnit(std::string_view si_unit) {
  if (si_unit == "m") return ChannelRole::kDisplacement;
  if (si_unit == "V") return ChannelRole::kVoltage;
  if (si_unit == "A") return ChannelRole::kCurrent;
  return ChannelRole::kOther;
}

}  // namespace haptometer::trial
