#pragma once

#include <complex>

#include "sim/actuator.h"
#include "sim/scene.h"
#include "sim/skin.h"

namespace haptometer::sim {

/// Mechanical impedance of the skin under the contact, force over velocity, in N s/m:
///
///   Zs = Bs + Ks / (j w),   w = 2 pi frequency_hz > 0.
[[nodiscard]] std::complex<double> SkinImpedance(const Skin& skin, double frequency_hz);

/// Mechanical impedance of actuator and adapter as the skin sees them, in N s/m, the terminals held
/// by a source without resistance (sim/tuning/motor_source.h for kc):
///
///   Zd = (1 / (1/D1 + 1/ka) - Ma2 w^2) / (j w),   D1 = kc - (Mc + Ma1) w^2,   ka = Ka + j w Ba;
///
/// without an adapter (kc - Mc w^2) / (j w). The force that would hold the skin's side still is
/// F0 = j w Xs (Zs + Zd) whatever the skin. Lindsay 2013, Figure 2.4, draws |Zs| and |Zd|.
[[nodiscard]] std::complex<double> DriverImpedance(const Scene& scene, double frequency_hz);

}  // namespace haptometer::sim
