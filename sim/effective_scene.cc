#include "sim/effective_scene.h"

#include <algorithm>

#include "base/check.h"
#include "sim/scene_mode.h"

namespace haptometer::sim {

double MoverSag(const Scene& scene) {
  return scene.actuator.moving_mass_kg * scene.effects.gravity_m_per_s2 /
         scene.actuator.stiffness_n_per_m;
}

double Weight(const Scene& scene) {
  const double adapter_kg = scene.adapter ? scene.adapter->skin_side_mass_kg : 0;
  return scene.effects.gravity_m_per_s2 *
         (scene.actuator.moving_mass_kg + CaseSideMass(scene) + adapter_kg);
}

EffectiveScene WithEffects(const Scene& scene, EffectSet on) {
  EffectiveScene effective{.scene = scene, .piecewise = {}};
  const Effects& effects = scene.effects;
  if (!on[PlaceOf(Effect::kInductance)]) effective.scene.actuator.inductance_h = 0;
  const bool gravity = on[PlaceOf(Effect::kGravity)];
  if (on[PlaceOf(Effect::kTravelStops)]) {
    HAPTOMETER_CHECK(effects.travel_stops.has_value(), "no stops");
    TravelStops& stops = effective.piecewise.stops.emplace(*effects.travel_stops);
    if (gravity) {
      stops.gap_up_m -= MoverSag(scene);
      stops.gap_down_m += MoverSag(scene);
    }
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

bool SteadyMotionIsFree(const EffectiveScene& scene, const SteadyState& steady) {
  const auto& [stops, loss] = scene.piecewise;
  const double room = 1 - steady.error_estimate;
  const bool clear =
      !stops || steady.mover_peak_m < room * std::min(stops->gap_up_m, stops->gap_down_m);
  return clear && (!loss || steady.skin_force_peak_n < room * loss->preload_n);
}

}  // namespace haptometer::sim
