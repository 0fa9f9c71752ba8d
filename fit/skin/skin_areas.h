#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fit/skin/skin_fit.h"

namespace haptometer::fit {

/// A constant of the skin under one contact.
struct AreaPoint {
  double area_m2 = 0;               ///< > 0
  double value = 0;                 ///< > 0, of Ks or Bs
  double relative_uncertainty = 0;  ///< statistical standard uncertainty over the value, > 0
  /// Change of ln(value) per share of each common input (the actuator's constants).
  std::vector<double> input_responses;
};

/// value = c (area / 1 mm2)^exponent.
struct AreaLaw {
  double exponent = 0;
  double standard_uncertainty = 0;           ///< statistical
  double combined_standard_uncertainty = 0;  ///< with the common inputs
  double at_one_mm2 = 0;                     ///< c
  double coverage_95 = 0;  ///< factor from the combined uncertainty to a 95 % interval
  /// Root of the mean square of the deviations in units of what the sweeps state; 0: two areas.
  double birge_ratio = 0;
  /// Whether the deviations are more than chance allows (chi-square beyond its 95 % point). Then
  /// the statistical uncertainty is multiplied by the Birge ratio, and coverage is Student's.
  bool scatters = false;
  std::vector<double> weights;  ///< exponent = sum weights ln(value)
};

/// Weighted straight line of ln(value) over ln(area); nothing for fewer than two areas that are at
/// least 10 % apart.
///
/// @param points one a contact
/// @param input_covariance relative covariance of the common inputs (inputs x inputs); empty: none
[[nodiscard]] std::optional<AreaLaw> FitAreaLaw(
    const std::vector<AreaPoint>& points, const std::vector<std::vector<double>>& input_covariance);

/// The exponent that `values` in the place of the fitted ones would give, with the same weights: of
/// a formula that is no power law, its mean slope over these areas.
[[nodiscard]] double ExponentOf(const AreaLaw& law, const std::vector<double>& values);

/// One of the skin's constants over the area of the contact.
struct AreaDependence {
  AreaLaw law;
  double lower_95 = 0;  ///< of the exponent
  double upper_95 = 0;
  bool holds_one_third = false;  ///< whether 1/3 lies in the interval
  /// Mean exponents over these areas of Lindsay's own formula (sim/skin/skin.h), which runs in a
  /// line with the cube root of the area and is no pure power law: for Ks with 600-2000 and with
  /// 600-1200 N/m, for Bs one number twice. Absent where an area lies outside of 1-100 mm2.
  std::optional<double> thesis_text;
  std::optional<double> thesis_table;
};

/// Whether an exponent lies in the 95 % interval.
[[nodiscard]] bool Holds(const AreaDependence& dependence, double exponent);

struct SkinAreas {
  std::optional<AreaDependence> stiffness;
  std::optional<AreaDependence> damping;
};

/// Fits Ks and Bs of those contacts that have an area and a determined value (AreaDependence). The
/// actuator's constants are common to all contacts, and move the exponent by what they move the
/// contacts differently; those of the first contact count.
[[nodiscard]] SkinAreas FitSkinAreas(const std::vector<SkinFit>& contacts);

}  // namespace haptometer::fit
