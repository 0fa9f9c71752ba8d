#pragma once

#include <fmt/core.h>

#include <cstddef>
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

/// "1 trial", "2 trials".
[[nodiscard]] inline std::string Counted(std::size_t count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

}  // namespace haptometer::tools
