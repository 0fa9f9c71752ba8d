#pragma once

#include <optional>
#include <vector>

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
/// @param input_covariance relative covariance of the common inputs (inputs x inputs); empty: none
[[nodiscard]] std::optional<AreaLaw> FitAreaLaw(
    const std::vector<AreaPoint>& points, const std::vector<std::vector<double>>& input_covariance);

/// The exponent that `values` in the place of the fitted ones would give, with the same weights: of
/// a formula that is no power law, its mean slope over these areas.
[[nodiscard]] double ExponentOf(const AreaLaw& law, const std::vector<double>& values);

}  // namespace haptometer::fit
