#include "sim/impedance.h"

#include <numbers>

#include "sim/tuning/motor_source.h"

namespace haptometer::sim {

using Complex = std::complex<double>;

Complex SkinImpedance(const Skin& skin, double frequency_hz) {
  const Complex s(0, 2 * std::numbers::pi * frequency_hz);
  return skin.damping_n_s_per_m + skin.stiffness_n_per_m / s;
}

Complex DriverImpedance(const Scene& scene, double frequency_hz) {
  const MotorSource source =
      SourceOf(scene.actuator, {.amplitude_v = 1, .frequency_hz = frequency_hz});
  const double w = source.omega_rad_per_s;
  const Complex s(0, w);
  const double Mc = source.case_mass_kg;
  if (!scene.adapter) return (source.stiffness_n_per_m - Mc * w * w) / s;
  const Adapter& adapter = *scene.adapter;
  const Complex D1 = source.stiffness_n_per_m - (Mc + adapter.motor_side_mass_kg) * w * w;
  const Complex ka(adapter.stiffness_n_per_m, adapter.damping_n_s_per_m * w);
  return (D1 * ka / (D1 + ka) - adapter.skin_side_mass_kg * w * w) / s;
}

}  // namespace haptometer::sim
