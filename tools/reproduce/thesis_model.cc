#include "tools/reproduce/thesis_model.h"

namespace haptometer::tools {

sim::Scene WithoutAdapter(const ThesisModel& model, double contact_area_m2) {
  sim::Scene scene;
  scene.actuator = model.actuator;
  scene.skin = sim::SkinUnderArea(contact_area_m2, model.skin_range);
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
