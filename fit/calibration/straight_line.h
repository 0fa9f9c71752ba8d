#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/error.h"

namespace haptometer::fit {

/// A point of a straight line with the standard uncertainties of both coordinates: at least one of
/// them above 0, independent of each other and of the other points.
struct LinePoint {
  double x = 0;
  double y = 0;
  double x_uncertainty = 0;  ///< in the unit of x
  double y_uncertainty = 0;  ///< in the unit of y
};

/// Where the uncertainty of the line comes from.
enum class Scatter : std::uint8_t {
  kStated,         ///< from the points' uncertainties; from the residuals where these exceed them
  kFromResiduals,  ///< from the residuals: the points' uncertainties are relative weights
};

/// y = intercept + slope * x.
struct StraightLine {
  double slope = 0;
  double intercept = 0;
  double slope_uncertainty = 0;  ///< standard uncertainties
  double intercept_uncertainty = 0;
  double covariance = 0;  ///< of slope and intercept
  /// Half-width of the 95 % interval in standard uncertainties: 1.96, or Student's t with n - 2
  /// degrees of freedom where the residuals give the uncertainty.
  double coverage_95 = 0;
  int degrees_of_freedom = 0;  ///< n - 2
  double birge_ratio = 0;      ///< sqrt(chi^2 / (n - 2)) of the points' uncertainties
  /// chi^2 is above its 99 % quantile: the uncertainties are widened.
  bool is_beyond_stated = false;
  std::vector<double> residuals{};  ///< y - intercept - slope * x

  /// Standard uncertainty of intercept + slope * x:
  ///   u^2 = u(a)^2 + x^2 u(b)^2 + 2 x cov(a, b)
  [[nodiscard]] double UncertaintyAt(double x) const;
};

/// The line of least weighted squares where both coordinates are uncertain.
///
/// Minimises sum W (y - a - b x)^2, W = 1 / (u(y)^2 + b^2 u(x)^2) (effective variance), by the
/// iteration of York et al., Am. J. Phys. 72, 367 (2004), eq. 13; uncertainties from its adjusted
/// points. With u(y) = 0 it is the inverse regression, with u(x) = 0 the usual one. With
/// Scatter::kFromResiduals covariances are multiplied by chi^2 / (n - 2), with kStated only where
/// chi^2 is beyond its 99 % quantile.
///
/// Errors (Cause::kCannotAnswer): fewer than 3 points, all x or all y alike, no convergence within
/// 200 iterations (points that lie on no line). Cost: O(n) an iteration, usually below 20.
[[nodiscard]] Result<StraightLine> FitStraightLine(std::span<const LinePoint> points,
                                                   Scatter scatter);

}  // namespace haptometer::fit
