#include "tools/cli/uncertain_number.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace haptometer::cli {

std::string WithUncertainty(double value, double standard_uncertainty) {
  if (!(standard_uncertainty > 0) || !std::isfinite(standard_uncertainty)) {
    return fmt::format("{:.6g}", value);
  }
  // the place of the uncertainty's second digit, after rounding (0.0996 shows as 0.10)
  int place = static_cast<int>(std::floor(std::log10(standard_uncertainty))) - 1;
  if (std::round(standard_uncertainty / std::pow(10.0, place)) >= 100) ++place;
  const double step = std::pow(10.0, place);
  const double digits = std::round(standard_uncertainty / step);
  if (place < 0) return fmt::format("{:.{}f}({:.0f})", value, -place, digits);
  return fmt::format("{:.0f}({:.0f})", std::round(value / step) * step, digits * step);
}

}  // namespace haptometer::cli
