#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "dsp/statistics/distributions.h"

namespace haptometer::tools {

/// In which unit a number is shown.
struct PrintedUnit {
  double size = 1;             ///< of one, in the number's own unit
  std::string_view name = {};  ///< "um"; empty: a ratio
};

/// "12.17 um (95 % CI 6.703 to 17.63)": four digits, or as many as show the interval to two digits
/// of its width; `otherwise` in parentheses where there is no interval.
[[nodiscard]] std::string WithCi(double value, const std::optional<dsp::Interval>& interval,
                                 std::string_view otherwise, const PrintedUnit& unit = {});

}  // namespace haptometer::tools
