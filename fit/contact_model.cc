#include "fit/contact_model.h"

#include <cmath>
#include <numbers>

namespace haptometer::fit {

using Complex = std::complex<double>;
using P = ContactParameter;

ContactValue ContactAt(const sim::Actuator& actuator, DriveQuantity drive,
                       const std::vector<double>& parameters, double frequency_hz) {
  const double w = 2 * std::numbers::pi * frequency_hz;
  const double Mv = actuator.moving_mass_kg, Mc = actuator.case_mass_kg;
  const double Km = actuator.force_constant_n_per_a;
  const double Ks = std::exp(parameters[Index(P::kStiffness)]);
  const double Bs = std::exp(parameters[Index(P::kDamping)]);
  const double m = parameters[Index(P::kMass)];
  const Complex D(actuator.stiffness_n_per_m, w * actuator.damping_n_s_per_m);
  const Complex T(Ks - w * w * (Mc + m), w * Bs);
  const Complex mover = D - w * w * Mv;

  // equations 2.2 and 2.3 for x = xa and y = xv - xa, per ampere
  const Complex denominator = T * mover - w * w * Mv * D;
  const Complex per_ampere = -w * w * Mv * Km / denominator;
  const Complex travel = (w * w * Mv * per_ampere - Km) / mover;
  // d ln(x/i)/dT
  Complex slope = -mover / denominator;
  ContactValue value{per_ampere, {}};
  if (drive == DriveQuantity::kVoltage) {
    const Complex impedance =
        Complex(actuator.resistance_ohm, w * actuator.inductance_h) - Complex(0, w * Km) * travel;
    value.motion = per_ampere / impedance;
    // the impedance moves with x/i, and d ln(x/v) = d ln(x/i) - dZ/Z
    const Complex impedance_slope = -Complex(0, w * Km) * (w * w * Mv / mover) * per_ampere * slope;
    slope -= impedance_slope / impedance;
  }
  value.logarithmic_slopes = {slope * Ks, slope * Complex(0, w * Bs), -slope * (w * w)};
  return value;
}

}  // namespace haptometer::fit
