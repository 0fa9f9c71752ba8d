#pragma once

#include <optional>
#include <string_view>

#include "trial/record.h"

namespace haptometer::trial {

/// A unit as tables print it.
struct PrintedUnit {
  std::string_view si_unit;  ///< "s", "m", "V" or "A"
  double factor = 1;         ///< one printed unit in SI
};

/// "s", "second(s)", "ms", "us", "m", "mm", "um", "V", "Volt(s)", "mV", "A", "Amp(s)", "mA" ...;
/// upper and lower case are alike but for a leading M, which is no milli.
[[nodiscard]] std::optional<PrintedUnit> FindUnit(std::string_view text);

/// What is measured in `si_unit`: "m" is a displacement, "V" a voltage, "A" a current.
[[nodiscard]] ChannelRole RoleOfUnit(std::string_view si_unit);

}  // namespace haptometer::trial
