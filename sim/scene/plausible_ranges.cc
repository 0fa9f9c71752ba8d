#include "sim/scene/plausible_ranges.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <variant>

namespace haptometer::sim {
namespace {

bool IsDoubted(const Findings& findings, const std::string& key) {
  return std::ranges::any_of(findings.list(), [&](const Finding& found) {
    return found.kind == FindingKind::kUnusualNumber &&
           std::get<std::string>(found.numbers.front().value) == key;
  });
}

void Doubt(std::string_view name, double value, const PlausibleRange& plausible,
           Findings& findings) {
  const std::string key(name);
  if (value == 0 || plausible.Holds(value) || IsDoubted(findings, key)) return;
  findings.Doubt(
      FindingKind::kUnusualNumber,
      {{"key", key}, {"value", value}, {"least", plausible.least}, {"most", plausible.most}});
}

void DoubtActuator(const Actuator& actuator, Findings& findings) {
  Doubt("actuator.moving_mass_kg", actuator.moving_mass_kg, kPlausibleMovingMassKg, findings);
  Doubt("actuator.case_mass_kg", actuator.case_mass_kg, kPlausibleCaseMassKg, findings);
  Doubt("actuator.force_constant_n_per_a", actuator.force_constant_n_per_a,
        kPlausibleForceConstantNPerA, findings);
  Doubt("actuator.resistance_ohm", actuator.resistance_ohm, kPlausibleResistanceOhm, findings);
  // a spring is judged with the mass on it; a wrong mass has its own doubt
  if (!kPlausibleMovingMassKg.Holds(actuator.moving_mass_kg)) return;
  Doubt("the actuator's resonance in Hz",
        std::sqrt(actuator.stiffness_n_per_m / actuator.moving_mass_kg) / (2 * std::numbers::pi),
        kPlausibleResonanceHz, findings);
}

}  // namespace

void DoubtUnusual(const Scene& scene, Findings& findings) {
  DoubtActuator(scene.actuator, findings);
  if (scene.adapter) {
    Doubt("adapter.motor_side_mass_kg", scene.adapter->motor_side_mass_kg, kPlausibleAdapterMassKg,
          findings);
    Doubt("adapter.skin_side_mass_kg", scene.adapter->skin_side_mass_kg, kPlausibleAdapterMassKg,
          findings);
  }
  Doubt("skin.stiffness_n_per_m", scene.skin.stiffness_n_per_m, kPlausibleSkinStiffnessNPerM,
        findings);
  Doubt("skin.damping_n_s_per_m", scene.skin.damping_n_s_per_m, kPlausibleSkinDampingNSPerM,
        findings);
  Doubt("the drive's frequency in Hz", HighestFrequencyHz(scene.drive), kPlausibleDriveHz,
        findings);
  Doubt("the drive's voltage in V", LargestVoltageV(scene.drive), kPlausibleDriveV, findings);
}

}  // namespace haptometer::sim
