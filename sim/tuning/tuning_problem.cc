#include "sim/tuning/tuning_problem.h"

#include <cmath>

#include "base/elementary_functions.h"

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

// the two skins of the variation that move least: largest damping, stiffness at either end
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
  // linear in the cube root of the area, in which the skin's law is linear
  const double lower = Cbrt(contact_area_m2.lower);
  const double root = lower + (Cbrt(contact_area_m2.upper) - lower) * part;
  return root * root * root;
}

std::optional<FindingKind> Fault(const TuningProblem& problem) {
  using enum FindingKind;
  const AdapterBounds& bounds = problem.bounds;
  for (const Range& range : {bounds.motor_side_mass_kg, bounds.skin_side_mass_kg,
                             bounds.stiffness_n_per_m, bounds.damping_n_s_per_m}) {
    if (!(range.lower <= range.upper)) return kBoundsCross;
    if (range.lower < 0) return kBoundNegative;
  }
  if (!(bounds.skin_side_mass_kg.lower > 0)) return kSkinSideMassNotPositive;
  if (!(bounds.stiffness_n_per_m.lower > 0)) return kStiffnessNotPositive;
  if (!(problem.skin_variation >= 0 && problem.skin_variation < 1)) return kSkinVariationOutside;
  if (!(problem.mover_limit_m > 0)) return kTravelNotPositive;
  if (problem.fixed_skin) {
    return problem.fixed_skin->damping_n_s_per_m > 0 ? std::nullopt : std::optional(kSkinUndamped);
  }
  const Range& area = bounds.contact_area_m2;
  const bool within = area.lower >= kSkinAreaMinM2 && area.upper <= kSkinAreaMaxM2;
  if (!(area.lower <= area.upper) || !within) return kAreaOutside;
  return std::nullopt;
}

double PartOf(const Range& range, double value) {
  return range.lower < range.upper ? (value - range.lower) / (range.upper - range.lower) : 0;
}

bool IsWide(const Range& range) { return range.lower > 0 && range.upper > 20 * range.lower; }

double ScaledAt(const Range& range, double part) {
  if (!IsWide(range)) return range.At(part);
  // the ends exactly
  if (part >= 1) return range.upper;
  // uniform in the logarithm
  return range.lower * Exp(part * Log(range.upper / range.lower));
}

double ScaledPartOf(const Range& range, double value) {
  if (!IsWide(range)) return PartOf(range, value);
  return Log(value / range.lower) / Log(range.upper / range.lower);
}

AdapterPoint PointOf(const AdapterBounds& bounds, const CubePlace& place) {
  return {.adapter = {.motor_side_mass_kg = bounds.motor_side_mass_kg.At(place[0]),
                      .skin_side_mass_kg = bounds.skin_side_mass_kg.At(place[4]),
                      .stiffness_n_per_m = ScaledAt(bounds.stiffness_n_per_m, place[1]),
                      .damping_n_s_per_m = ScaledAt(bounds.damping_n_s_per_m, place[2])},
          .contact_area_m2 = AreaAt(bounds.contact_area_m2, place[3])};
}

CubePlace PlaceOf(const AdapterBounds& bounds, const AdapterPoint& point) {
  const Range roots{.lower = Cbrt(bounds.contact_area_m2.lower),
                    .upper = Cbrt(bounds.contact_area_m2.upper)};
  return {PartOf(bounds.motor_side_mass_kg, point.adapter.motor_side_mass_kg),
          ScaledPartOf(bounds.stiffness_n_per_m, point.adapter.stiffness_n_per_m),
          ScaledPartOf(bounds.damping_n_s_per_m, point.adapter.damping_n_s_per_m),
          PartOf(roots, Cbrt(point.contact_area_m2)),
          PartOf(bounds.skin_side_mass_kg, point.adapter.skin_side_mass_kg)};
}

CubePlace UpperEndOf(const TuningProblem& problem) {
  const AdapterBounds& bounds = problem.bounds;
  // an axis of no width is fixed at 0
  const auto end = [](const Range& range) { return range.lower < range.upper ? 1.0 : 0.0; };
  return {end(bounds.motor_side_mass_kg), end(bounds.stiffness_n_per_m),
          end(bounds.damping_n_s_per_m), problem.fixed_skin ? 0 : end(bounds.contact_area_m2),
          end(bounds.skin_side_mass_kg)};
}

std::vector<CubePlace> Lattice(const CubePlace& upper,
                               const std::array<std::vector<double>, 4>& parts) {
  std::vector<CubePlace> places;
  for (const double Ma1 : parts[0]) {
    for (const double Ka : parts[1]) {
      for (const double Ba : parts[2]) {
        for (const double area : parts[3]) {
          const CubePlace place{Ma1, Ka, Ba, area, 0};
          // places off a fixed axis are dropped
          if ((place.array() <= upper.array()).all()) places.push_back(place);
        }
      }
    }
  }
  return places;
}

}  // namespace haptometer::sim
