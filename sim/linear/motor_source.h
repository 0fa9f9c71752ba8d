#pragma once

#include <array>
#include <complex>
#include <cstdint>
#include <string_view>

#include "sim/scene/actuator.h"
#include "sim/scene/scene.h"
#include "sim/skin/skin.h"

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

/// Mechanical impedance of the skin under the contact, force over velocity, in N s/m:
///
///   Zs = Bs + Ks / (j w),   w = 2 pi frequency_hz > 0.
[[nodiscard]] std::complex<double> SkinImpedance(const Skin& skin, double frequency_hz);

/// Mechanical impedance of actuator and adapter as the skin sees them, in N s/m, the terminals held
/// by a source without resistance (sim/linear/motor_source.h for kc):
///
///   Zd = (1 / (1/D1 + 1/ka) - Ma2 w^2) / (j w),   D1 = kc - (Mc + Ma1) w^2,   ka = Ka + j w Ba;
///
/// without an adapter (kc - Mc w^2) / (j w). The force that would hold the skin's side still is
/// F0 = j w Xs (Zs + Zd) whatever the skin. Lindsay 2013, Figure 2.4, draws |Zs| and |Zd|.
[[nodiscard]] std::complex<double> DriverImpedance(const Scene& scene, double frequency_hz);

/// One of the six numbers of adapter and skin.
enum class SceneNumber : std::uint8_t { kMa1, kMa2, kKa, kBa, kKs, kBs };
inline constexpr std::array kSceneNumbers{SceneNumber::kMa1, SceneNumber::kMa2, SceneNumber::kKa,
                                          SceneNumber::kBa,  SceneNumber::kKs,  SceneNumber::kBs};

/// "Ma1", "Ma2", "Ka", "Ba", "Ks", "Bs".
[[nodiscard]] std::string_view Symbol(SceneNumber number);

/// The scene with one of its numbers `factor` times as large. It must have an adapter.
[[nodiscard]] Scene Scaled(Scene scene, SceneNumber number, double factor);

/// RMS of the skin in the steady state of Scaled() over that of `scene` (Lindsay 2013, Figure 2.5).
/// Cost: two steady states.
[[nodiscard]] double RelativeSkinRms(const Scene& scene, SceneNumber number, double factor);

}  // namespace haptometer::sim
