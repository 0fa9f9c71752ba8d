#include "tools/cli/band.h"

#include <fmt/core.h>

#include <cctype>

#include "base/quantity.h"

namespace haptometer::cli {

Result<Band> ParseBand(const std::string& text) {
  const auto dash = text.find('-', 1);
  if (dash == std::string::npos) {
    return Usage("--band", fmt::format("'{}' is not a band", text), "write it as 20-500Hz");
  }
  std::string lower = text.substr(0, dash);
  const std::string upper = text.substr(dash + 1);
  if (std::isalpha(static_cast<unsigned char>(lower.back())) == 0) {
    const auto unit = upper.find_last_not_of("kMHz") + 1;
    lower += upper.substr(unit);
  }
  const auto lower_hz = ParseQuantity(lower, Dimension::kFrequency, "--band");
  if (!lower_hz) return std::unexpected(lower_hz.error());
  const auto upper_hz = ParseQuantity(upper, Dimension::kFrequency, "--band");
  if (!upper_hz) return std::unexpected(upper_hz.error());
  return Band{.lower_hz = lower_hz->value, .upper_hz = upper_hz->value};
}

}  // namespace haptometer::cli
