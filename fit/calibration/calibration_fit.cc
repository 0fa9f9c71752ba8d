#include "fit/calibration/calibration_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "dsp/statistics/distributions.h"

namespace haptometer::fit {
namespace {

// a probability of 1 % to take noise for a curve
constexpr double kByChance = 0.01;
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

// a cubic through residuals over z = (x - middle) / half range, from -1 to 1
struct Cubic {
  Eigen::Vector4d terms = Eigen::Vector4d::Zero();
  double explained = 0;  // sum of squares
  double left = 0;
  double freedom = 0;
  double half_range = 0;

  // against chance: exact points have no noise to test against
  [[nodiscard]] bool IsCurved() const {
    return left > 0 && dsp::FisherUpperP(explained / 2 / (left / freedom), 2, freedom) < kByChance;
  }
  // RMS over the range of its slope over the line's: mean over z of (q1 + 2 q2 z + 3 q3 z^2)^2
  [[nodiscard]] double LocalSlope(double slope) const {
    const double square = terms[1] * terms[1] + 4. / 3 * terms[2] * terms[2] +
                          9. / 5 * terms[3] * terms[3] + 2 * terms[1] * terms[3];
    return std::sqrt(square) / half_range / std::abs(slope);
  }
};

// nothing of fewer than six points, or four places of x
std::optional<Cubic> CubicOf(std::span<const LinePoint> points,
                             const std::vector<double>& residuals) {
  constexpr std::size_t kLeastPoints = 6;
  constexpr int kTerms = 4;
  if (points.size() < kLeastPoints) return std::nullopt;
  const auto [least, most] = std::ranges::minmax(points, {}, &LinePoint::x);
  Cubic cubic{.freedom = static_cast<double>(points.size() - kTerms),
              .half_range = (most.x - least.x) / 2};
  Eigen::MatrixXd terms(points.size(), kTerms);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double z = (points[i].x - least.x) / cubic.half_range - 1;
    terms.row(static_cast<Eigen::Index>(i)) << 1, z, z * z, z * z * z;
  }
  const Eigen::Map<const Eigen::VectorXd> of(residuals.data(), std::ssize(residuals));
  const auto solver = terms.colPivHouseholderQr();
  if (solver.rank() < kTerms) return std::nullopt;
  cubic.terms = solver.solve(of);
  cubic.explained = (terms * cubic.terms).squaredNorm();
  cubic.left = (of - terms * cubic.terms).squaredNorm();
  return cubic;
}

// The outliers, unless they are points of a curve: a cubic through all points explains them better
// than chance does, leaves no more than the line of the others, and is no steeper than a sensor's
// curve. A cubic alone shows nothing, as it bends to any one point at an end.
std::optional<Outliers> OutliersOffTheLine(std::span<const LinePoint> points, Scatter scatter,
                                           const StraightLine& line) {
  constexpr double kSteepestCurve = 0.05;  // of the local slope, RMS
  constexpr double kAsLittle = 10;         // of variances of few degrees of freedom
  auto found = FindOutliers(points, scatter);
  const auto cubic = CubicOf(points, line.residuals);
  if (!found || !cubic || !cubic->IsCurved()) return found;
  if (cubic->LocalSlope(found->others.slope) > kSteepestCurve) return found;
  double squares = 0;
  for (const double residual : found->others.residuals) squares += residual * residual;
  const double of_line = squares / found->others.degrees_of_freedom;
  if (cubic->left / cubic->freedom < kAsLittle * of_line) return std::nullopt;
  return found;
}

// sum of squares that residuals leave of a line and a step before the point `first`
double LeftByStep(std::span<const LinePoint> points, const std::vector<double>& residuals,
                  std::size_t first, Eigen::Vector3d* terms) {
  Eigen::MatrixX3d columns(points.size(), 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    columns.row(static_cast<Eigen::Index>(i)) << 1, points[i].x, i < first ? 0.0 : 1.0;
  }
  const Eigen::Map<const Eigen::VectorXd> of(residuals.data(), std::ssize(residuals));
  const auto solver = columns.colPivHouseholderQr();
  // no step that a line could not be told from
  if (solver.rank() < 3) return of.squaredNorm();
  *terms = solver.solve(of);
  return (of - columns * *terms).squaredNorm();
}

std::optional<Slip> SlipOf(std::span<const LinePoint> points, const StraightLine& line) {
  constexpr std::size_t kLeastPoints = 6;
  constexpr double kRounding = 1e-9;  // of the range of y
  if (points.size() < kLeastPoints) return std::nullopt;
  Slip slip;
  double least = HUGE_VAL;
  // at least two points on either side
  for (std::size_t first = 2; first + 2 <= points.size(); ++first) {
    Eigen::Vector3d terms = Eigen::Vector3d::Zero();
    const double left = LeftByStep(points, line.residuals, first, &terms);
    if (left >= least) continue;
    least = left;
    slip = {.point = first, .step = terms[2], .slope = line.slope + terms[1]};
  }
  const auto [lowest, highest] = std::ranges::minmax(points, {}, &LinePoint::y);
  if (std::abs(slip.step) < kRounding * (highest.y - lowest.y)) return std::nullopt;
  // the best of so many steps, and better than a curve
  const auto freedom = static_cast<double>(points.size() - 3);
  double all = 0;
  for (const double residual : line.residuals) all += residual * residual;
  const double chance = dsp::FisherUpperP((all - least) / (least / freedom), 1, freedom);
  const auto cubic = CubicOf(points, line.residuals);
  if (chance > kByChance / freedom || (cubic && cubic->left / cubic->freedom < least / freedom)) {
    return std::nullopt;
  }
  return slip;
}

// of the points that are no outliers
void AddCurvature(std::span<const LinePoint> points, CalibrationFit& fit) {
  const auto cubic = fit.outliers ? CubicOf(fit.outliers->kept, fit.outliers->others.residuals)
                                  : CubicOf(points, fit.line.residuals);
  fit.is_curved = cubic && cubic->IsCurved();
  if (fit.is_curved) fit.local_slope_uncertainty = cubic->LocalSlope(fit.line.slope);
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
  fit.outliers = OutliersOffTheLine(points, scatter, fit.line);
  // play of the stage is a step where the direction turns
  const bool has_play = fit.hysteresis && fit.hysteresis->is_significant;
  if (!fit.outliers && !has_play) fit.slip = SlipOf(points, fit.line);
  AddCurvature(points, fit);
  const double of_slope = fit.line.coverage_95 * fit.line.slope_uncertainty /
                          (dsp::kNormalCritical * std::abs(fit.line.slope));
  fit.relative_uncertainty = std::hypot(of_slope, fit.local_slope_uncertainty);
  return fit;
}

std::optional<double> NormalizedError(double a, double a_uncertainty, double b,
                                      double b_uncertainty) {
  constexpr double kCoverage = 2;
  constexpr double kRounding = 1e-12;
  if (a == b) return 0;
  const double uncertainty = std::hypot(a_uncertainty, b_uncertainty);
  if (!(uncertainty > kRounding * std::max(std::abs(a), std::abs(b)))) return std::nullopt;
  return (a - b) / (kCoverage * uncertainty);
}

}  // namespace haptometer::fit
