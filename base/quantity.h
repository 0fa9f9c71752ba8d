#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/error.h"

namespace haptometer {

/// What a quantity measures. Lengths, masses and inductances need a unit; the others may be bare SI
/// numbers, because nobody writes a frequency in kHz without saying so, but many write 10 for 10
/// mm.
enum class Dimension : std::uint8_t {
  kNone,           ///< a plain number or ratio
  kLength,         ///< m, mm, um, nm                 (unit required)
  kMass,           ///< kg, g, mg                     (unit required)
  kInductance,     ///< H, mH, uH                     (unit required)
  kTime,           ///< s, ms, us, min, h
  kFrequency,      ///< Hz, kHz, MHz
  kVoltage,        ///< V, mV, uV
  kCurrent,        ///< A, mA
  kResistance,     ///< ohm, mohm, kohm, Mohm; "inf" and "open" are infinite
  kStiffness,      ///< N/m, N/mm
  kDamping,        ///< N s/m (also Ns/m, N*s/m)
  kForceConstant,  ///< N/A
  kArea,           ///< m2, cm2, mm2
};

/// Magnitudes that a quantity of a dimension can have; 0 is possible in each.
///
/// The limits, in SI units: length 1e-15 to 1e6, mass 1e-12 to 1e6, inductance 1e-12 to 1e6, time
/// 1e-12 to 1e12, frequency 1e-9 to 1e12, voltage and current 1e-15 to 1e9, resistance 1e-9 to
/// 1e15, stiffness 1e-9 to 1e15, damping 1e-12 to 1e12, force constant 1e-9 to 1e9, area 1e-15 to
/// 1e6, a plain number 1e-30 to 1e30. They are wide of every device; what lies outside is a typing
/// error, and arithmetic with it can overflow or underflow.
struct PossibleMagnitudes {
  double least = 0;
  double largest = 0;
};

[[nodiscard]] PossibleMagnitudes PossibleMagnitudesOf(Dimension dimension);

/// A number with its standard uncertainty, both in SI units.
struct Quantity {
  double value = 0;
  double standard_uncertainty = 0;  ///< 0: stated as exact

  [[nodiscard]] bool exact() const { return standard_uncertainty == 0; }
  bool operator==(const Quantity&) const = default;
};

/// What a number without a unit is where its dimension needs one.
enum class BareNumber : std::uint8_t {
  kRefused,    ///< with the customary unit as a proposal: 10 may be 10 mm
  kRefusedSi,  ///< with the SI unit as a proposal: of a text under a key that ends in that unit
  kIsSi,       ///< the SI number: of a word for a key that ends in that unit
};

/// Reads "1.4g", "10 mm", "27", "1.40(3)g", "1.40g+-0.03g" (also ± and +/-) as SI.
///
/// The concise form's bracket counts in units of the last digit: 1.40(3) g is 1.40 g with u = 0.03
/// g. Both "u" and "µ" (either code point) mean micro. `where` names the option or key in errors.
/// Errors (Cause::kUsage): not a number, an unknown unit, a unit of another dimension, a negative
/// uncertainty, a bare length, mass or inductance ("did you mean 10mm?") unless `bare` is kIsSi,
/// NaN, infinity except for resistances, a magnitude outside PossibleMagnitudesOf.
[[nodiscard]] Result<Quantity> ParseQuantity(std::string_view text, Dimension dimension,
                                             std::string_view where,
                                             BareNumber bare = BareNumber::kRefused);

/// `quantity` where its value and uncertainty are possible in `dimension`, for a number that was
/// not read by ParseQuantity; an infinite resistance is. Errors (Cause::kUsage): not finite, or a
/// magnitude outside PossibleMagnitudesOf.
[[nodiscard]] Result<Quantity> PossibleQuantity(Quantity quantity, Dimension dimension,
                                                std::string_view where);

/// The coherent SI unit of `dimension` as text: "m", "N s/m", "" for kNone.
[[nodiscard]] std::string_view SiUnit(Dimension dimension);

}  // namespace haptometer
