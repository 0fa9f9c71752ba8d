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

void Doubt(std::string_view name, double value, const PlausibleRange& usual, Findings& findings) {
  const std::string key(name);
  if (value == 0 || usual.Holds(value) || IsDoubted(findings, key)) return;
  findings.Doubt(FindingKind::kUnusualNumber,
                 {{"key", key}, {"value", value}, {"least", usual.least}, {"most", usual.most}});
}

void DoubtActuator(const Actuator& actuator, Findings& findings) {
  Doubt("actuator.moving_mass_kg", actuator.moving_mass_kg, kUsualMovingMassKg, findings);
  Doubt("actuator.case_mass_kg", actuator.case_mass_kg, kUsualCaseMassKg, findings);
  Doubt("actuator.force_constant_n_per_a", actuator.force_constant_n_per_a,
        kUsualForceConstantNPerA, findings);
  Doubt("actuator.resistance_ohm", actuator.resistance_ohm, kUsualResistanceOhm, findings);
  // a spring is judged with the mass on it; a wrong mass has its own doubt
  if (!kUsualMovingMassKg.Holds(actuator.moving_mass_kg)) return;
  Doubt("the actuator's resonance in Hz",
        std::sqrt(actuator.stiffness_n_per_m / actuator.moving_mass_kg) / (2 * std::numbers::pi),
        kUsualResonanceHz, findings);
}

}  // namespace

void DoubtUnusual(const Scene& scene, Findings& findings) {
  DoubtActuator(scene.actuator, findings);
  if (scene.adapter) {
    Doubt("adapter.motor_side_mass_kg", scene.adapter->motor_side_mass_kg, kUsualAdapterMassKg,
          findings);
    Doubt("adapter.skin_side_mass_kg", scene.adapter->skin_side_mass_kg, kUsualAdapterMassKg,
          findings);
  }
  Doubt("skin.stiffness_n_per_m", scene.skin.stiffness_n_per_m, kUsualSkinStiffnessNPerM, findings);
  Doubt("skin.damping_n_s_per_m", scene.skin.damping_n_s_per_m, kUsualSkinDampingNSPerM, findings);
  Doubt("the drive's frequency in Hz", HighestFrequencyHz(scene.drive), kUsualDriveHz, findings);
  Doubt("the drive's voltage in V", LargestVoltageV(scene.drive), kUsualDriveV, findings);
}

}  // namespace haptometer::sim
