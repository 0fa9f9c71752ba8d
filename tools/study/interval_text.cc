#include "tools/study/interval_text.h"

#include <fmt/core.h>

#include "tools/cli/uncertain_number.h"

namespace haptometer::tools {
namespace {

constexpr int kDigits = 4;  // at least

}  // namespace

std::string WithCi(double value, const std::optional<dsp::Interval>& interval,
                   std::string_view otherwise, const PrintedUnit& unit) {
  const std::string name = unit.name.empty() ? "" : fmt::format(" {}", unit.name);
  if (!interval) return fmt::format("{:.{}g}{} ({})", value / unit.size, kDigits, name, otherwise);
  const double lower = interval->lower / unit.size;
  const double upper = interval->upper / unit.size;
  return fmt::format("{1:.{0}g}{2} (95 % CI {3:.{0}g} to {4:.{0}g})",
                     cli::DigitsOf(lower, upper, kDigits), value / unit.size, name, lower, upper);
}

}  // namespace haptometer::tools
