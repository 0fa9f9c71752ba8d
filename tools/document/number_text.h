#pragma once

#include <array>
#include <string>
#include <string_view>

namespace haptometer::document {

/// A unit in which people say a value: `factor` of it is one SI unit.
struct SpokenUnit {
  double factor = 1;
  std::string_view symbol = {};  ///< "um"; empty: none
};

/// The SI unit of a value.
struct Unit {
  std::string_view ending = {};  ///< of keys of that unit: "_n_per_m"
  std::string_view symbol = {};  ///< "N/m"
  /// How people say it, from the smallest unit to the largest.
  std::array<SpokenUnit, 3> spoken{};

  /// How they say a number of that size (without its sign, SI): the largest unit of which it is one
  /// at least.
  [[nodiscard]] constexpr SpokenUnit For(double size) const {
    SpokenUnit best = spoken[0];
    for (const SpokenUnit& larger : spoken) {
      if (!larger.symbol.empty() && size * larger.factor >= 1) best = larger;
    }
    return best;
  }
};

inline constexpr Unit kNone{};
inline constexpr Unit kShare{"", "", {{{100, "%"}}}};  ///< a part of one
inline constexpr Unit kMetre{"_m", "m", {{{1e6, "um"}, {1e3, "mm"}, {1, "m"}}}};
inline constexpr Unit kSquareMetre{"_m2", "m2", {{{1e6, "mm2"}}}};
inline constexpr Unit kSecond{"_s", "s", {{{1e3, "ms"}, {1, "s"}}}};
inline constexpr Unit kHertz{"_hz", "Hz", {{{1, "Hz"}}}};
inline constexpr Unit kRadian{"_rad", "rad", {{{57.295779513082321, "degrees"}}}};
inline constexpr Unit kVolt{"_v", "V", {{{1e3, "mV"}, {1, "V"}}}};
inline constexpr Unit kAmpere{"_a", "A", {{{1e3, "mA"}, {1, "A"}}}};
inline constexpr Unit kOhm{"_ohm", "ohm", {{{1, "ohm"}}}};
inline constexpr Unit kHenry{"_h", "H", {{{1e6, "uH"}, {1e3, "mH"}, {1, "H"}}}};
inline constexpr Unit kWatt{"_w", "W", {{{1e3, "mW"}, {1, "W"}}}};
inline constexpr Unit kVoltAmpere{"_va", "VA", {{{1e3, "mVA"}, {1, "VA"}}}};
inline constexpr Unit kKilogram{"_kg", "kg", {{{1e3, "g"}}}};
inline constexpr Unit kKelvin{"_k", "K", {{{1, "K"}}}};
inline constexpr Unit kNewton{"_n", "N", {{{1, "N"}}}};
inline constexpr Unit kMetrePerSecond{
    "_m_per_s", "m/s", {{{1e6, "um/s"}, {1e3, "mm/s"}, {1, "m/s"}}}};
inline constexpr Unit kMetrePerSecondSquared{"_m_per_s2", "m/s^2", {{{1, "m/s^2"}}}};
inline constexpr Unit kMetrePerVolt{"_m_per_v", "m/V", {{{1e6, "um/V"}, {1e3, "mm/V"}}}};
inline constexpr Unit kMetrePerWatt{"_m_per_w", "m/W", {{{1e6, "um/W"}, {1e3, "mm/W"}}}};
inline constexpr Unit kNewtonPerMetre{"_n_per_m", "N/m", {{{1, "N/m"}}}};
inline constexpr Unit kNewtonSecondPerMetre{"_n_s_per_m", "N s/m", {{{1, "N s/m"}}}};
inline constexpr Unit kNewtonPerAmpere{"_n_per_a", "N/A", {{{1, "N/A"}}}};
inline constexpr Unit kPerSecond{"_per_s", "1/s", {{{1, "1/s"}}}};
inline constexpr Unit kPerSecondSquared{"_per_s2", "1/s^2", {{{1, "1/s^2"}}}};

/// The unit that a name ends with; the longest ending counts.
[[nodiscard]] Unit UnitOfName(std::string_view name);

/// `value` with its standard uncertainty in the last digits, all three in one unit: "70.71(12)",
/// "12350(670)", "1.234(12)e+12".
///
/// Two digits of the uncertainty, rounded to even (JCGM 100:2008, 7.2.2, third form, and 7.2.6).
/// Nothing finer than the decimal place of `resolution`, where that is above 0; an uncertainty
/// below that place is shown as one unit of it. Without an uncertainty (0, or not finite), and with
/// one below 1e-7 of the value, which no instrument states: `digits` significant digits at most and
/// no bracket. 0 is "0", and what rounds to it has no sign.
[[nodiscard]] std::string NumberText(double value, double standard_uncertainty, double resolution,
                                     int digits = 6);

/// "LOWER to UPPER", both to the last digit that NumberText() shows of a value with this
/// uncertainty; without one six digits of each.
[[nodiscard]] std::string RangeText(double lower, double upper, double standard_uncertainty,
                                    double resolution);

/// A number in SI units, with the prefix that suits it: "2.5 mm"; with a standard uncertainty
/// "2.54(12) mm", else `digits` significant digits.
[[nodiscard]] std::string QuantityText(double value, const Unit& unit, int digits,
                                       double standard_uncertainty = 0);

}  // namespace haptometer::document
