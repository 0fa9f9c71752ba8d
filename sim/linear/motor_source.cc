#include "sim/linear/motor_source.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "base/circular_functions.h"
#include "base/error.h"
#include "sim/linear/steady_state.h"

namespace haptometer::sim {
namespace {
using Complex = std::complex<double>;
}  // namespace

MotorSource SourceOf(const Actuator& actuator, const SineDrive& drive) {
  HAPTOMETER_CHECK(drive.frequency_hz > 0, "frequency_hz = {}", drive.frequency_hz);
  HAPTOMETER_CHECK(actuator.resistance_ohm > 0 && actuator.moving_mass_kg > 0, "{} ohm, {} kg",
                   actuator.resistance_ohm, actuator.moving_mass_kg);
  const double Mv = actuator.moving_mass_kg, Kv = actuator.stiffness_n_per_m;
  const double Bv = actuator.damping_n_s_per_m, Km = actuator.force_constant_n_per_a;
  const double V = drive.amplitude_v;
  const Complex s(0, 2 * std::numbers::pi * drive.frequency_hz);
  const Complex coil = actuator.resistance_ohm + actuator.inductance_h * s;

  // the coil folded into the spring, then the moving mass eliminated
  const Complex k1 = Kv + Bv * s + Km * Km * s / coil;
  const Complex d1 = Mv * s * s + k1;
  const Complex F = Km * V / coil;
  const Complex through = Mv * s * s / d1;  // 1 - k1 / d1 without its cancellation

  MotorSource source{.omega_rad_per_s = s.imag(),
                     .force_n = F * through,
                     .stiffness_n_per_m = k1 * through,
                     .case_mass_kg = actuator.case_mass_kg,
                     .coil_force_n = F,
                     .coupling_damping_n_per_m = k1.imag(),
                     .free_travel_m = F / d1,
                     .travel_per_case = through};
  // i = (v - Km (va - vv)) / coil with Xa - Xv = Xa (1 - k1 / d1) + F / d1
  // P = Re(V conj(I)) / 2, linear in the case's motion Xa
  source.blocked_power_w = V / 2 * ((V - Km * s * F / d1) / coil).real();
  source.power_slope_w_per_m = -V / 2 * Km * s * through / coil;
  const Complex kc = source.stiffness_n_per_m;
  // rounding, amplified where 1 - k1/d1 and Im kc are small differences
  source.rounding_allowance = 64 * std::numeric_limits<double>::epsilon() *
                              std::norm(1 + Abs(k1 / d1)) * (1 + Abs(kc) / kc.imag());
  return source;
}

AdapterMotion MotionOf(const MotorSource& source, const Adapter& adapter, const Skin& skin) {
  const double w = source.omega_rad_per_s;
  const double Mc1 = source.case_mass_kg + adapter.motor_side_mass_kg;
  const Complex D1 = source.stiffness_n_per_m - Mc1 * w * w;
  const Complex D2(skin.stiffness_n_per_m - adapter.skin_side_mass_kg * w * w,
                   skin.damping_n_s_per_m * w);
  const Complex stretch = D2 / Complex(adapter.stiffness_n_per_m, adapter.damping_n_s_per_m * w);
  // Xs = Fc / (D1 D2 / ka + D1 + D2), peak, m
  const Complex skin_m = source.force_n / (D1 * stretch + D1 + D2);
  return {.case_m = skin_m * (1.0 + stretch), .skin_m = skin_m};
}

double MoverTravel(const MotorSource& source, std::complex<double> case_m) {
  return Abs(source.travel_per_case * case_m + source.free_travel_m);
}

double ElectricalPower(const MotorSource& source, std::complex<double> case_m) {
  return source.blocked_power_w + (source.power_slope_w_per_m * case_m).real();
}

Complex SkinImpedance(const Skin& skin, double frequency_hz) {
  const Complex s(0, 2 * std::numbers::pi * frequency_hz);
  // Zs = Bs + Ks / s, N s/m
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
  // (1 / (1/D1 + 1/ka) - Ma2 w^2) / s, N s/m
  return (D1 * ka / (D1 + ka) - adapter.skin_side_mass_kg * w * w) / s;
}

std::string_view Symbol(SceneNumber number) {
  constexpr std::array<std::string_view, kSceneNumbers.size()> kSymbols{"Ma1", "Ma2", "Ka",
                                                                        "Ba",  "Ks",  "Bs"};
  return kSymbols[static_cast<std::size_t>(number)];
}

Scene Scaled(Scene scene, SceneNumber number, double factor) {
  HAPTOMETER_CHECK(scene.adapter.has_value(), "the scene has no adapter");
  Adapter& adapter = *scene.adapter;
  const std::array<double*, kSceneNumbers.size()> places{
      &adapter.motor_side_mass_kg, &adapter.skin_side_mass_kg,    &adapter.stiffness_n_per_m,
      &adapter.damping_n_s_per_m,  &scene.skin.stiffness_n_per_m, &scene.skin.damping_n_s_per_m};
  *places[static_cast<std::size_t>(number)] *= factor;
  return scene;
}

double RelativeSkinRms(const Scene& scene, SceneNumber number, double factor) {
  return SolveSteadyState(Scaled(scene, number, factor)).skin_rms_m /
         SolveSteadyState(scene).skin_rms_m;
}

}  // namespace haptometer::sim
