#include "sim/sensitivity.h"

#include "base/error.h"
#include "sim/steady_state.h"

namespace haptometer::sim {

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
