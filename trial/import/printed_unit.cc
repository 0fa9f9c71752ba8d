#include "trial/import/printed_unit.h"

#include <algorithm>
#include <array>
#include <string>

namespace haptometer::trial {
namespace {

struct UnitName {
  std::string_view name;
  PrintedUnit unit;
};

constexpr std::array<UnitName, 33> kUnits{{{"s", {"s", 1}},
                                           {"sec", {"s", 1}},
                                           {"second", {"s", 1}},
                                           {"seconds", {"s", 1}},
                                           {"ms", {"s", 1e-3}},
                                           {"us", {"s", 1e-6}},
                                           {"\xc2\xb5s", {"s", 1e-6}},
                                           {"\xce\xbcs", {"s", 1e-6}},
                                           {"ns", {"s", 1e-9}},
                                           {"m", {"m", 1}},
                                           {"meter", {"m", 1}},
                                           {"meters", {"m", 1}},
                                           {"mm", {"m", 1e-3}},
                                           {"um", {"m", 1e-6}},
                                           {"\xc2\xb5m", {"m", 1e-6}},
                                           {"\xce\xbcm", {"m", 1e-6}},
                                           {"nm", {"m", 1e-9}},
                                           {"v", {"V", 1}},
                                           {"volt", {"V", 1}},
                                           {"volts", {"V", 1}},
                                           {"mv", {"V", 1e-3}},
                                           {"millivolts", {"V", 1e-3}},
                                           {"uv", {"V", 1e-6}},
                                           {"\xc2\xb5v", {"V", 1e-6}},
                                           {"\xce\xbcv", {"V", 1e-6}},
                                           {"a", {"A", 1}},
                                           {"amp", {"A", 1}},
                                           {"amps", {"A", 1}},
                                           {"ampere", {"A", 1}},
                                           {"amperes", {"A", 1}},
                                           {"ma", {"A", 1e-3}},
                                           {"milliamps", {"A", 1e-3}},
                                           {"ua", {"A", 1e-6}}}};

}  // namespace

std::optional<PrintedUnit> FindUnit(std::string_view text) {
  const bool is_mega = text.size() > 1 && text[0] == 'M' && text.size() < 3;
  if (is_mega) return std::nullopt;
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
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
