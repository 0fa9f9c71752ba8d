#include "fit/skin_areas.h"

#include <algorithm>

#include "sim/skin/skin.h"

namespace haptometer::fit {
namespace {

// which of a contact's two constants
struct Which {
  FittedValue SkinFit::* value;
  double SkinInfluence::* influence;
  double sim::Skin::* thesis;
};

std::vector<std::vector<double>> Covariance(const SkinFit& contact) {
  std::vector<std::vector<double>> covariance;
  covariance.reserve(contact.actuator_covariance.size());
  for (const auto& row : contact.actuator_covariance)
    covariance.emplace_back(row.begin(), row.end());
  return covariance;
}

AreaPoint PointOf(const SkinFit& contact, const Which& which) {
  const FittedValue& value = contact.*which.value;
  AreaPoint point{*contact.area_m2, value.value, value.standard_uncertainty / value.value, {}};
  for (const auto& influence : contact.influences) {
    point.input_responses.push_back(influence.*which.influence);
  }
  return point;
}

std::optional<double> ThesisExponent(const AreaLaw& law, const std::vector<AreaPoint>& points,
                                     sim::SkinRange range, const Which& which) {
  std::vector<double> values;
  values.reserve(points.size());
  for (const auto& point : points) {
    if (point.area_m2 < sim::kSkinAreaMinM2 || point.area_m2 > sim::kSkinAreaMaxM2) return {};
    values.push_back(sim::SkinUnderArea(point.area_m2, range).*which.thesis);
  }
  return ExponentOf(law, values);
}

std::optional<AreaDependence> Depend(const std::vector<SkinFit>& contacts, const Which& which) {
  std::vector<AreaPoint> points;
  std::vector<std::vector<double>> covariance;
  for (const auto& contact : contacts) {
    if (!contact.area_m2 || !(contact.*which.value).determined) continue;
    if (points.empty()) covariance = Covariance(contact);
    points.push_back(PointOf(contact, which));
  }
  const auto law = FitAreaLaw(points, covariance);
  if (!law) return {};
  const double half = law->coverage_95 * law->combined_standard_uncertainty;
  AreaDependence dependence{.law = *law,
                            .lower_95 = law->exponent - half,
                            .upper_95 = law->exponent + half,
                            .holds_one_third = false,
                            .thesis_text = {},
                            .thesis_table = {}};
  dependence.holds_one_third = Holds(dependence, 1.0 / 3);
  dependence.thesis_text = ThesisExponent(*law, points, sim::SkinRange::kText, which);
  dependence.thesis_table = ThesisExponent(*law, points, sim::SkinRange::kTable, which);
  return dependence;
}

}  // namespace

bool Holds(const AreaDependence& dependence, double exponent) {
  return exponent >= dependence.lower_95 && exponent <= dependence.upper_95;
}

SkinAreas FitSkinAreas(const std::vector<SkinFit>& contacts) {
  return {
      .stiffness =
          Depend(contacts, {&SkinFit::stiffness, &SkinInfluence::stiffness_percent_per_percent,
                            &sim::Skin::stiffness_n_per_m}),
      .damping = Depend(contacts, {&SkinFit::damping, &SkinInfluence::damping_percent_per_percent,
                                   &sim::Skin::damping_n_s_per_m})};
}

}  // namespace haptometer::fit
