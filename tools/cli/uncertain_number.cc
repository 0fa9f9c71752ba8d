#include "tools/cli/uncertain_number.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace haptometer::cli {

namespace {

constexpr int kMostDigits = 12;  // an end's round-off is not shown

bool IsKnown(double standard_uncertainty) {
  return standard_uncertainty > 0 && std::isfinite(standard_uncertainty);
}

// the place of the uncertainty's second digit, after rounding (0.0996 shows as 0.10)
int PlaceOf(double standard_uncertainty) {
  const int place = static_cast<int>(std::floor(std::log10(standard_uncertainty))) - 1;
  return std::round(standard_uncertainty / std::pow(10.0, place)) >= 100 ? place + 1 : place;
}

// what rounds to nothing has no sign
std::string WithoutSignOfZero(std::string text) {
  if (text.starts_with('-') && text.find_first_of("123456789") == std::string::npos)
    text.erase(0, 1);
  return text;
}

}  // namespace

std::string ToThePlaceOf(double standard_uncertainty, double value) {
  if (!IsKnown(standard_uncertainty)) return WithoutSignOfZero(fmt::format("{:.6g}", value));
  const int place = PlaceOf(standard_uncertainty);
  if (place < 0) return WithoutSignOfZero(fmt::format("{:.{}f}", value, -place));
  const double step = std::pow(10.0, place);
  return WithoutSignOfZero(fmt::format("{:.0f}", std::round(value / step) * step));
}

std::string WithUncertainty(double value, double standard_uncertainty) {
  std::string text = ToThePlaceOf(standard_uncertainty, value);
  if (!IsKnown(standard_uncertainty)) return text;
  const int place = PlaceOf(standard_uncertainty);
  const double digits = std::round(standard_uncertainty / std::pow(10.0, place));
  return fmt::format("{}({:.0f})", text, digits * std::pow(10.0, std::max(0, place)));
}

int DecimalsOf(double lower, double upper, int least) {
  const double width = upper - lower;
  return IsKnown(width) ? std::clamp(-PlaceOf(width), least, kMostDigits) : least;
}

int DigitsOf(double lower, double upper, int least) {
  const double width = upper - lower;
  const double larger = std::max(std::abs(lower), std::abs(upper));
  if (!IsKnown(width) || !IsKnown(larger)) return least;
  const int before = static_cast<int>(std::floor(std::log10(larger))) + 1;
  return std::clamp(before - PlaceOf(width), least, kMostDigits);
}

}  // namespace haptometer::cli
