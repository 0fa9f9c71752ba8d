#include "sim/tuning/adapter_bounds.h"

#include <cmath>

namespace haptometer::sim {

AdapterBounds ThesisBounds() {
  return {.motor_side_mass_kg = {0.25e-3, 10e-3},
          .skin_side_mass_kg = {0.25e-3, 10e-3},
          .stiffness_n_per_m = {2000, 12000},
          .damping_n_s_per_m = {0.01, 0.1},
          .contact_area_m2 = {kSkinAreaMinM2, kSkinAreaMaxM2}};
}

TuningProblem ThesisProblem() {
  return {.actuator = ThesisC10100(),
          .drive = {.amplitude_v = 5, .frequency_hz = 225},
          .bounds = ThesisBounds()};
}

Skin SkinOf(const TuningProblem& problem, double contact_area_m2) {
  if (problem.fixed_skin) return *problem.fixed_skin;
  return SkinUnderArea(contact_area_m2, problem.skin_range);
}

std::array<Skin, 2> HardestSkins(const TuningProblem& problem, double contact_area_m2) {
  const Skin skin = SkinOf(problem, contact_area_m2);
  const double v = problem.skin_variation;
  const double most_damping = skin.damping_n_s_per_m * (1 + v);
  return {Skin{skin.stiffness_n_per_m * (1 - v), most_damping},
          Skin{skin.stiffness_n_per_m * (1 + v), most_damping}};
}

double AreaAt(const Range& contact_area_m2, double part) {
  // the ends as stated, not as a cube of a cube root
  if (part <= 0) return contact_area_m2.lower;
  if (part >= 1) return contact_area_m2.upper;
  const double lower = std::cbrt(contact_area_m2.lower);
  const double root = lower + (std::cbrt(contact_area_m2.upper) - lower) * part;
  return root * root * root;
}

std::optional<const char*> Fault(const TuningProblem& problem) {
  const AdapterBounds& bounds = problem.bounds;
  for (const Range& range : {bounds.motor_side_mass_kg, bounds.skin_side_mass_kg,
                             bounds.stiffness_n_per_m, bounds.damping_n_s_per_m}) {
    if (!(range.lower <= range.upper)) return "a lower bound lies above its upper bound";
    if (range.lower < 0) return "a bound is negative";
  }
  if (!(bounds.skin_side_mass_kg.lower > 0)) return "the skin side's mass must be above 0";
  if (!(bounds.stiffness_n_per_m.lower > 0)) return "the stiffness must be above 0";
  if (!(problem.skin_variation >= 0 && problem.skin_variation < 1)) {
    return "the skin's variation must be from 0 to below 1";
  }
  if (!(problem.mover_limit_m > 0)) return "the mover's travel must be above 0";
  if (problem.fixed_skin) {
    return problem.fixed_skin->damping_n_s_per_m > 0 ? std::nullopt
                                                     : std::optional("the skin has no damping");
  }
  const Range& area = bounds.contact_area_m2;
  const bool within = area.lower >= kSkinAreaMinM2 && area.upper <= kSkinAreaMaxM2;
  if (!(area.lower <= area.upper) || !within) return "the area must lie between 1 and 100 mm2";
  return std::nullopt;
}

}  // namespace haptometer::sim
