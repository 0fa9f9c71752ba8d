#include "fit/calibration/calibration_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "dsp/statistics/distributions.h"

namespace haptometer::fit {
namespace {

constexpr double kNormal95 = 1.959963984540054;
// a probability of 1 % to take noise for a curve
constexpr double kCurved = 0.01;
// hysteresis is reported as such beyond so many standard uncertainties
constexpr double kSignificant = 3;

std::vector<int> DirectionsOf(std::span<const LinePoint> points) {
  std::vector<int> directions(points.size());
  for (std::size_t i = 1; i < points.size(); ++i) {
    // a repeated level was approached as the one before it
    const double rise = points[i].y - points[i - 1].y;
    directions[i] = rise == 0 ? directions[i - 1] : rise > 0 ? 1 : -1;
  }
  return directions;
}

std::optional<Hysteresis> HysteresisOf(const std::vector<double>& residuals,
                                       const std::vector<int>& directions) {
  double sums[2]{};
  double squares[2]{};
  double counts[2]{};
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    if (directions[i] == 0) continue;
    const std::size_t side = directions[i] > 0 ? 1 : 0;
    sums[side] += residuals[i];
    squares[side] += residuals[i] * residuals[i];
    ++counts[side];
  }
  if (counts[0] < 2 || counts[1] < 2) return std::nullopt;
  Hysteresis found;
  // Welch's two-sample variance: u^2 = s1^2 / n1 + s2^2 / n2
  double variance = 0;
  for (std::size_t side = 0; side < 2; ++side) {
    const double mean = sums[side] / counts[side];
    found.difference += side == 1 ? mean : -mean;
    variance += (squares[side] / counts[side] - mean * mean) / (counts[side] - 1);
  }
  found.standard_uncertainty = std::sqrt(std::max(variance, 0.0));
  found.is_significant = std::abs(found.difference) > kSignificant * found.standard_uncertainty;
  return found;
}

// a cubic through the residuals over z = (x - middle) / half range, from -1 to 1
void AddCurvature(std::span<const LinePoint> points, CalibrationFit& fit) {
  constexpr std::size_t kLeastPoints = 6;
  constexpr int kTerms = 4;
  if (points.size() < kLeastPoints) return;
  const auto [least, most] = std::ranges::minmax(points, {}, &LinePoint::x);
  const double half_range = (most.x - least.x) / 2;
  Eigen::MatrixXd terms(points.size(), kTerms);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double z = (points[i].x - least.x) / half_range - 1;
    terms.row(static_cast<Eigen::Index>(i)) << 1, z, z * z, z * z * z;
  }
  const Eigen::Map<const Eigen::VectorXd> residuals(
      fit.line.residuals.data(), static_cast<Eigen::Index>(fit.line.residuals.size()));
  const auto solver = terms.colPivHouseholderQr();
  // fewer than four places of x determine no cubic
  if (solver.rank() < kTerms) return;
  const Eigen::Vector4d q = solver.solve(residuals);
  const double explained = (terms * q).squaredNorm();
  const double left = (residuals - terms * q).squaredNorm();
  const auto freedom = static_cast<double>(points.size() - kTerms);
  // exact points: no noise to test against
  if (!(left > 0)) return;
  const double f = explained / 2 / (left / freedom);
  fit.is_curved = dsp::FisherUpperP(f, 2, freedom) < kCurved;
  if (!fit.is_curved) return;
  // mean over z of (q1 + 2 q2 z + 3 q3 z^2)^2
  const double square = q[1] * q[1] + 4. / 3 * q[2] * q[2] + 9. / 5 * q[3] * q[3] + 2 * q[1] * q[3];
  fit.local_slope_uncertainty = std::sqrt(square) / half_range / std::abs(fit.line.slope);
}

}  // namespace

Result<CalibrationFit> FitCalibration(std::span<const LinePoint> points, Scatter scatter) {
  CalibrationFit fit;
  HAPTOMETER_LET(fit.line, FitStraightLine(points, scatter));
  const auto farthest = std::ranges::max_element(
      fit.line.residuals, {}, [](double residual) { return std::abs(residual); });
  fit.farthest = static_cast<std::size_t>(farthest - fit.line.residuals.begin());
  fit.nonlinearity = std::abs(*farthest);
  fit.directions = DirectionsOf(points);
  fit.hysteresis = HysteresisOf(fit.line.residuals, fit.directions);
  AddCurvature(points, fit);
  const double of_slope =
      fit.line.coverage_95 * fit.line.slope_uncertainty / (kNormal95 * std::abs(fit.line.slope));
  fit.relative_uncertainty = std::hypot(of_slope, fit.local_slope_uncertainty);
  return fit;
}

double NormalizedError(double a, double a_uncertainty, double b, double b_uncertainty) {
  constexpr double kCoverage = 2;
  if (a == b) return 0;
  return (a - b) / (kCoverage * std::hypot(a_uncertainty, b_uncertainty));
}

}  // namespace haptometer::fit
