#pragma once

#include <complex>

#include "sim/actuator.h"
#include "sim/scene.h"

namespace haptometer::sim {

/// A driven actuator as its massless case is seen from outside at one frequency: a force behind a
/// complex stiffness (Thevenin's theorem for the moving mass, its spring and the coil).
///
/// With s = j w, k1 = Kv + Bv s + Km^2 s / (R + L s), d1 = Mv s^2 + k1, F = Km V / (R + L s):
///
///   kc = k1 - k1^2 / d1,   Fc = F (1 - k1 / d1),
///   Xa = Fc / (kc + what is fixed to the case),
///   P  = P0 + Re(beta Xa)      mean electrical power, P0 that of a case that cannot move.
///
/// Im kc > 0: the actuator is passive, and its coil has a resistance.
struct MotorSource {
  double omega_rad_per_s = 0;
  std::complex<double> force_n;                ///< Fc, the blocked force, peak
  std::complex<double> stiffness_n_per_m;      ///< kc; Mc and Ma1 are not in it
  double case_mass_kg = 0;                     ///< Mc
  std::complex<double> coil_force_n;           ///< F
  double coupling_damping_n_per_m = 0;         ///< Im k1: what the mover's travel dissipates by
  std::complex<double> free_travel_m;          ///< F / d1: the mover's in a case that cannot move
  std::complex<double> travel_per_case;        ///< 1 - k1 / d1
  double blocked_power_w = 0;                  ///< P0
  std::complex<double> power_slope_w_per_m{};  ///< beta
  /// How far the rounding of kc and Fc may move an RMS, relative: 64 eps (1 + |k1/d1|)^2
  /// (1 + |kc| / Im kc), a generous count of the operations that made them.
  double rounding_allowance = 0;
};

/// The source that `actuator` is under `drive`; both as AssembleModel() wants them.
[[nodiscard]] MotorSource SourceOf(const Actuator& actuator, const SineDrive& drive);

/// Peak phasors of case and skin under the source with an adapter between.
struct AdapterMotion {
  std::complex<double> case_m;
  std::complex<double> skin_m;
};

/// The motion in closed form, with D1 = kc - (Mc + Ma1) w^2, D2 = Ks + Bs s - Ma2 w^2,
/// ka = Ka + Ba s:
///
///   Xs = Fc / (D1 D2 / ka + D1 + D2),   Xa = Xs (1 + D2 / ka).
///
/// The same numbers as SolveSteadyState() to a few roundings, in 20 ns instead of 3 us.
[[nodiscard]] AdapterMotion MotionOf(const MotorSource& source, const Adapter& adapter,
                                     const Skin& skin);

/// The mover's travel in its case, |Xv - Xa| = |(1 - k1/d1) Xa + F/d1|, peak, of a case that moves
/// by the peak phasor `case_m`.
[[nodiscard]] double MoverTravel(const MotorSource& source, std::complex<double> case_m);

/// Mean electrical power of a case that moves by the peak phasor `case_m`, in W.
[[nodiscard]] double ElectricalPower(const MotorSource& source, std::complex<double> case_m);

}  // namespace haptometer::sim
