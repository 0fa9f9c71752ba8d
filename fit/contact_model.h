#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/scene/actuator.h"

namespace haptometer::fit {

/// The parameters of the skin under a contact.
enum class ContactParameter : std::uint8_t {
  kStiffness,  ///< ln Ks, N/m
  kDamping,    ///< ln Bs, N s/m
  kMass,       ///< m itself in kg: what moves with the contact besides the case
};
inline constexpr std::size_t kContactParameters = 3;

[[nodiscard]] constexpr std::size_t Index(ContactParameter parameter) {
  return static_cast<std::size_t>(parameter);
}

/// What drives the actuator in a measurement.
enum class DriveQuantity : std::uint8_t { kCurrent, kVoltage };

/// Displacement of the contact per unit of drive, and d ln(that) by the parameters.
struct ContactValue {
  std::complex<double> motion;  ///< m/A or m/V
  std::array<std::complex<double>, kContactParameters> logarithmic_slopes;
};

/// The contact's steady motion under an actuator whose case lies on the skin (directly, or through
/// a rigid contactor), J. Lindsay, University of Washington 2013, equations 2.1-2.3 with the skin's
/// spring, damper and mass m on the case. With w = 2 pi frequency_hz, D = Kv + j w Bv and
/// T = Ks + j w Bs - w^2 (Mc + m):
///
///     x/i = -w^2 Mv Km / (T (D - w^2 Mv) - w^2 Mv D),
///     v/i = R + j w L - j w Km y,   y = (w^2 Mv x/i - Km) / (D - w^2 Mv),
///
/// y being the mover's travel in the case per ampere. Equal to sim/linear/steady_state.h, which
/// solves the five states, to rounding (a test holds it to that), for m = 0 or with m counted into
/// Mc. Cost: 100 ns.
[[nodiscard]] ContactValue ContactAt(const sim::Actuator& actuator, DriveQuantity drive,
                                     const std::vector<double>& parameters, double frequency_hz);

}  // namespace haptometer::fit
