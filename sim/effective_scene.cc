#include "sim/effective_scene.h"

#include <algorithm>

#include "base/check.h"
#include "sim/scene_mode.h"

namespace haptometer::sim {

double MoverSag(const Scene& scene, bool stiffening) {
  const double weight_n = scene.actuator.moving_mass_kg * scene.effects.gravity_m_per_s2;
  const bool hardens = stiffening && scene.effects.stiffening;
  return SagUnder(weight_n, scene.actuator.stiffness_n_per_m,
                  hardens ? scene.effects.stiffening->cubic_n_per_m3 : 0);
}

double Weight(const Scene& scene) {
  const double adapter_kg = scene.adapter ? scene.adapter->skin_side_mass_kg : 0;
  return scene.effects.gravity_m_per_s2 *
         (scene.actuator.moving_mass_kg + CaseSideMass(scene) + adapter_kg);
}

EffectiveScene WithEffects(const Scene& scene, EffectSet on) {
  EffectiveScene effective{.scene = scene, .piecewise = {}, .outputs_rate_hz = OutputRateHz(scene)};
  const Effects& effects = scene.effects;
  if (!on[PlaceOf(Effect::kInductance)]) effective.scene.actuator.inductance_h = 0;
  if (!on[PlaceOf(Effect::kTremor)]) effective.scene.finger.tones.clear();
  const bool gravity = on[PlaceOf(Effect::kGravity)];
  const bool stiffening = on[PlaceOf(Effect::kStiffening)];
  const double sag_m = gravity ? MoverSag(scene, stiffening) : 0;
  if (stiffening) {
    HAPTOMETER_CHECK(effects.stiffening.has_value(), "no spring");
    effective.smooth.spring.emplace(*effects.stiffening).sag_m = sag_m;
  }
  if (on[PlaceOf(Effect::kCoilHeating)]) {
    HAPTOMETER_CHECK(effects.coil_heating.has_value(), "no heat capacity");
    effective.smooth.heating = effects.coil_heating;
  }
  if (on[PlaceOf(Effect::kTravelStops)]) {
    HAPTOMETER_CHECK(effects.travel_stops.has_value(), "no stops");
    TravelStops& stops = effective.piecewise.stops.emplace(*effects.travel_stops);
    stops.gap_up_m -= sag_m;
    stops.gap_down_m += sag_m;
  }
  if (on[PlaceOf(Effect::kContactLoss)]) {
    HAPTOMETER_CHECK(effects.contact_loss.has_value(), "no preload");
    ContactLoss& loss = effective.piecewise.contact_loss.emplace(*effects.contact_loss);
    if (gravity) loss.preload_n += Weight(scene);
  }
  return effective;
}

bool CanRest(const EffectiveScene& scene) {
  const auto& [stops, loss] = scene.piecewise;
  if (stops && !(std::min(stops->gap_up_m, stops->gap_down_m) > 0)) return false;
  const Skin& skin = scene.scene.skin;
  return !loss ||
         (loss->preload_n > 0 && (skin.stiffness_n_per_m > 0 || skin.damping_n_s_per_m > 0));
}

namespace {

bool IsFree(const EffectiveScene& scene, double travel_m, double skin_force_n, double error) {
  const auto& [stops, loss] = scene.piecewise;
  const double room = 1 - error;
  const bool clear = !stops || travel_m < room * std::min(stops->gap_up_m, stops->gap_down_m);
  return scene.IsLinear() && clear && (!loss || skin_force_n < room * loss->preload_n);
}

}  // namespace

bool SteadyMotionIsFree(const EffectiveScene& scene, const SteadyState& steady) {
  return scene.scene.finger.tones.empty() &&
         IsFree(scene, steady.mover_peak_m, steady.skin_force_peak_n, steady.error_estimate);
}

bool SteadyMotionIsFree(const EffectiveScene& scene, const Superposition& steady) {
  return IsFree(scene, steady.mover_peak_m, steady.skin_force_peak_n, steady.error_estimate);
}

}  // namespace haptometer::sim
