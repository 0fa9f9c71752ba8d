#include "tools/reproduce/thesis_model.h"

namespace haptometer::tools {

sim::Skin SkinOf(const ThesisModel& model, double contact_area_m2) {
  const auto law = [&](double area_m2) { return sim::SkinUnderArea(area_m2, model.skin_range); };
  const double least = law(sim::kSkinAreaMinM2).stiffness_n_per_m;
  const double largest = law(sim::kSkinAreaMaxM2).stiffness_n_per_m;
  sim::Skin skin = law(contact_area_m2);
  const double part = (skin.stiffness_n_per_m - least) / (largest - least);
  skin.stiffness_n_per_m +=
      (1 - part) * model.least_skin.stiffness_n_per_m + part * model.largest_skin.stiffness_n_per_m;
  skin.damping_n_s_per_m +=
      (1 - part) * model.least_skin.damping_n_s_per_m + part * model.largest_skin.damping_n_s_per_m;
  return skin;
}

sim::Scene WithoutAdapter(const ThesisModel& model, double contact_area_m2) {
  sim::Scene scene;
  scene.actuator = model.actuator;
  scene.skin = SkinOf(model, contact_area_m2);
  scene.drive = model.drive;
  return scene;
}

sim::Scene WithAdapter(const ThesisModel& model, double contact_area_m2) {
  sim::Scene scene = WithoutAdapter(model, contact_area_m2);
  scene.adapter = model.adapter;
  return scene;
}

sim::Scene Prototype(const ThesisModel& model, double contact_area_m2) {
  sim::Scene scene = WithAdapter(model, contact_area_m2);
  scene.adapter->skin_side_mass_kg = kBuiltBaseMassKg;
  return scene;
}

sim::TuningProblem SearchOf(const ThesisModel& model) {
  sim::TuningProblem problem = sim::ThesisProblem();
  problem.actuator = model.actuator;
  problem.drive = model.drive;
  problem.skin_range = model.skin_range;
  return problem;
}

}  // namespace haptometer::tools
