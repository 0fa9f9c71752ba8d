#include "tools/document/number_text.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace haptometer::document {
namespace {

constexpr int kMostPlaces = 9;  // before or behind the point; beyond them a power of ten

// a number that rounds to 0 has no sign: "-0.00" becomes "0.00"
std::string WithoutSignOfZero(std::string text) {
  if (text.starts_with('-') && text.find_first_of("123456789") == std::string::npos)
    text.erase(0, 1);
  return text;
}

// rounded to 10^place, the finest digit that is shown
std::string ToPlace(double value, int place) {
  if (place < 0) return WithoutSignOfZero(fmt::format("{:.{}f}", value, -place));
  const double step = std::pow(10.0, place);
  return WithoutSignOfZero(fmt::format("{:.0f}", std::round(value / step) * step));
}

// power of ten of the first digit; 1e-9 since a computed resolution of 0.01 may lie just below
int PlaceOf(double size) { return static_cast<int>(std::floor(std::log10(size) + 1e-9)); }

// the place of the uncertainty's second digit after rounding (0.0996 is shown as 0.10); not finer
// than the resolution
int PlaceOfUncertainty(double uncertainty, double resolution) {
  const int first = static_cast<int>(std::floor(std::log10(uncertainty)));
  const int place = std::round(uncertainty / std::pow(10.0, first - 1)) >= 100 ? first : first - 1;
  return resolution > 0 ? std::max(place, PlaceOf(resolution)) : place;
}

// an uncertainty below 1e-7 of the value, which no instrument states, is not shown
bool IsShown(double uncertainty, double value) {
  constexpr double kLeastRelative = 1e-7;
  return std::isfinite(uncertainty) && uncertainty > 0 &&
         uncertainty >= kLeastRelative * std::abs(value);
}

std::string PlainText(double value, double resolution, int digits) {
  if (value == 0) return "0";
  // an open end of a range has no decimal place
  if (!std::isfinite(value)) return fmt::format("{:g}", value);
  // the resolution limits the digits where it is coarser than the last of `digits`
  const bool is_limited =
      resolution > 0 && PlaceOf(resolution) > PlaceOf(std::abs(value)) - digits + 1;
  // a large number is rounded and has no power of ten: "10240" to four digits
  const int place = PlaceOf(std::abs(value)) - digits + 1;
  if (!is_limited && place >= 0 && std::abs(value) < std::pow(10.0, kMostPlaces)) {
    return ToPlace(value, place);
  }
  if (!is_limited) return fmt::format("{:.{}g}", value, digits);
  if (PlaceOf(resolution) < -kMostPlaces) {
    return fmt::format("{:.{}g}", value,
                       std::max(1, PlaceOf(std::abs(value)) - PlaceOf(resolution) + 1));
  }
  const std::string text = ToPlace(value, PlaceOf(resolution));
  return text.find_first_of("123456789") == std::string::npos ? "0" : text;
}

}  // namespace

// the longest ending counts: "_n_per_m" ends with "_m" too
Unit UnitOfName(std::string_view name) {
  Unit longest;
  for (const Unit& unit :
       {kMetre,           kSquareMetre,  kSecond,          kHertz,
        kRadian,          kVolt,         kAmpere,          kOhm,
        kHenry,           kWatt,         kVoltAmpere,      kKilogram,
        kKelvin,          kNewton,       kMetrePerSecond,  kMetrePerSecondSquared,
        kMetrePerVolt,    kMetrePerWatt, kNewtonPerMetre,  kNewtonSecondPerMetre,
        kNewtonPerAmpere, kPerSecond,    kPerSecondSquared}) {
    if (name.ends_with(unit.ending) && unit.ending.size() > longest.ending.size()) longest = unit;
  }
  return longest;
}

// two digits of uncertainty in brackets, in units of the last digit (JCGM 100:2008, 7.2.2)
std::string NumberText(double value, double standard_uncertainty, double resolution, int digits) {
  if (!IsShown(standard_uncertainty, value)) return PlainText(value, resolution, digits);
  const double larger = std::max(std::abs(value), standard_uncertainty);
  const int exponent = static_cast<int>(std::floor(std::log10(larger)));
  const int place = PlaceOfUncertainty(standard_uncertainty, resolution);
  // outside of kMostPlaces: mantissa with uncertainty, then a power of ten for both
  if (exponent >= kMostPlaces || place < -kMostPlaces) {
    const double scale = std::pow(10.0, exponent);
    return NumberText(value / scale, standard_uncertainty / scale, resolution / scale) +
           fmt::format("e{:+03d}", exponent);
  }
  // at least one unit of the last digit: 0 would state an exact value
  const double in_place = std::round(standard_uncertainty / std::pow(10.0, place));
  return fmt::format("{}({:.0f})", ToPlace(value, place),
                     std::max(1.0, in_place) * std::pow(10.0, std::max(0, place)));
}

// both ends rounded to the place of one uncertainty
std::string RangeText(double lower, double upper, double standard_uncertainty, double resolution) {
  const bool is_shown = IsShown(standard_uncertainty, std::max(std::abs(lower), std::abs(upper)));
  const int place = is_shown ? PlaceOfUncertainty(standard_uncertainty, resolution) : 0;
  const auto end = [&](double number) {
    if (!is_shown || std::abs(place) > kMostPlaces) return PlainText(number, resolution, 6);
    return ToPlace(number, place);
  };
  return fmt::format("{} to {}", end(lower), end(upper));
}

std::string QuantityText(double value, const Unit& unit, int digits, double standard_uncertainty) {
  const auto [factor, symbol] = unit.For(std::abs(value));
  return fmt::format("{}{}{}", NumberText(value * factor, standard_uncertainty * factor, 0, digits),
                     symbol.empty() ? "" : " ", symbol);
}

}  // namespace haptometer::document
