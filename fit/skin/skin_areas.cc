#include "fit/skin/skin_areas.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/mapped.h"
#include "dsp/statistics/distributions.h"
#include "sim/skin/skin.h"

namespace haptometer::fit {
namespace {

constexpr double kSquareMillimetre = 1e-6;
// largest over smallest area below which an exponent is not determined
constexpr double kLeastRatio = 1.1;

// ln(area / 1 mm2)
double LogArea(const AreaPoint& point) { return std::log(point.area_m2 / kSquareMillimetre); }

double Weight(const AreaPoint& point) {
  // a clean sweep's uncertainty is rounding's
  return 1 / std::max(point.relative_uncertainty * point.relative_uncertainty, 1e-24);
}

// chi^2 of the points about a straight line in logarithms
double ChiSquare(const std::vector<AreaPoint>& points, const AreaLaw& law) {
  double square = 0;
  for (const auto& point : points) {
    const double line = std::log(law.at_one_mm2) + law.exponent * LogArea(point);
    square += Weight(point) * std::pow(std::log(point.value) - line, 2);
  }
  return square;
}

}  // namespace

std::optional<AreaLaw> FitAreaLaw(const std::vector<AreaPoint>& points,
                                  const std::vector<std::vector<double>>& input_covariance) {
  if (points.size() < 2) return {};
  const auto [least, most] = std::ranges::minmax_element(points, {}, &AreaPoint::area_m2);
  if (most->area_m2 < kLeastRatio * least->area_m2) return {};
  // weighted means of ln area and ln value
  double weights = 0, middle = 0, level = 0;
  for (const auto& point : points) {
    weights += Weight(point);
    middle += Weight(point) * LogArea(point);
    level += Weight(point) * std::log(point.value);
  }
  middle /= weights;
  level /= weights;
  double spread = 0;
  for (const auto& point : points) spread += Weight(point) * std::pow(LogArea(point) - middle, 2);

  // the exponent is linear in the ln values: the same weights propagate their uncertainties
  AreaLaw law;
  for (const auto& point : points) {
    law.weights.push_back(Weight(point) * (LogArea(point) - middle) / spread);
    law.exponent += law.weights.back() * std::log(point.value);
  }
  law.at_one_mm2 = std::exp(level - law.exponent * middle);
  law.standard_uncertainty = 1 / std::sqrt(spread);
  law.coverage_95 = kCoverage95;
  // three points and more: scatter beyond chi^2 widens by the Birge ratio, with Student's t
  if (points.size() > 2) {
    const auto degrees = static_cast<double>(points.size() - 2);
    const double square = ChiSquare(points, law);
    law.birge_ratio = std::sqrt(square / degrees);
    law.scatters = square > dsp::ChiSquareQuantile(0.95, degrees);
    if (law.scatters) {
      law.standard_uncertainty *= law.birge_ratio;
      law.coverage_95 = dsp::StudentCritical(degrees);
    }
  }
  // type B: an actuator's error moves all areas together, by g' C g
  std::vector<double> responses(input_covariance.size(), 0.0);
  for (std::size_t k = 0; k < responses.size(); ++k) {
    for (std::size_t n = 0; n < points.size(); ++n) {
      responses[k] += law.weights[n] * points[n].input_responses.at(k);
    }
  }
  double variance = law.standard_uncertainty * law.standard_uncertainty;
  for (std::size_t i = 0; i < responses.size(); ++i) {
    for (std::size_t k = 0; k < responses.size(); ++k) {
      variance += responses[i] * input_covariance[i][k] * responses[k];
    }
  }
  law.combined_standard_uncertainty = std::sqrt(variance);
  return law;
}

double ExponentOf(const AreaLaw& law, const std::vector<double>& values) {
  HAPTOMETER_CHECK(values.size() == law.weights.size(), "{} values, {} areas", values.size(),
                   law.weights.size());
  double exponent = 0;
  for (std::size_t n = 0; n < values.size(); ++n) exponent += law.weights[n] * std::log(values[n]);
  return exponent;
}

namespace {

// which of a contact's two constants
struct Which {
  FittedValue SkinFit::* value;
  double SkinInfluence::* influence;
  double sim::Skin::* thesis;
};

std::vector<std::vector<double>> Covariance(const SkinFit& contact) {
  return Mapped<std::vector<double>>(contact.actuator_covariance, [](const auto& row) {
    return std::vector<double>(row.begin(), row.end());
  });
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
    // the thesis's formula holds within its own range of areas only
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
