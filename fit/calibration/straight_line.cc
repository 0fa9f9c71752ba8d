#include "fit/calibration/straight_line.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "dsp/statistics/distributions.h"

namespace haptometer::fit {
namespace {

constexpr int kMostIterations = 200;
constexpr double kConverged = 1e-15;
// a probability of 1 % to widen uncertainties that were stated rightly
constexpr double kBeyondStated = 0.99;

// weighted sums about the weighted means, at one slope
struct Step {
  double slope = 0;   // the next one
  double mean_x = 0;  // weighted
  double mean_y = 0;
  double weights = 0;      // sum of W
  double adjusted_x = 0;   // weighted mean of the adjusted x
  double adjusted_xx = 0;  // weighted sum of their squares about it
};

double WeightOf(const LinePoint& point, double slope) {
  return 1 / (point.y_uncertainty * point.y_uncertainty +
              slope * slope * point.x_uncertainty * point.x_uncertainty);
}

// beta: distance of the adjusted x from the mean (York et al. 2004, eq. 13c, without correlation)
double BetaOf(const LinePoint& point, double slope, const Step& step) {
  const double of_x = (point.x - step.mean_x) * point.y_uncertainty * point.y_uncertainty;
  const double of_y = (point.y - step.mean_y) * point.x_uncertainty * point.x_uncertainty;
  return WeightOf(point, slope) * (of_x + slope * of_y);
}

Step StepAt(std::span<const LinePoint> points, double slope) {
  Step step;
  // weighted means
  for (const LinePoint& point : points) {
    const double weight = WeightOf(point, slope);
    step.weights += weight;
    step.mean_x += weight * point.x;
    step.mean_y += weight * point.y;
  }
  step.mean_x /= step.weights;
  step.mean_y /= step.weights;
  // b = sum(W beta V) / sum(W beta U)
  double numerator = 0;
  double denominator = 0;
  double mean_beta = 0;
  for (const LinePoint& point : points) {
    const double weighted = WeightOf(point, slope) * BetaOf(point, slope, step);
    numerator += weighted * (point.y - step.mean_y);
    denominator += weighted * (point.x - step.mean_x);
    mean_beta += weighted / step.weights;
  }
  step.slope = numerator / denominator;
  // adjusted points: u = x_adjusted - mean of these
  step.adjusted_x = step.mean_x + mean_beta;
  for (const LinePoint& point : points) {
    const double u = BetaOf(point, slope, step) - mean_beta;
    step.adjusted_xx += WeightOf(point, slope) * u * u;
  }
  return step;
}

// slope of the usual regression of y on x, where the iteration starts; not finite where all x are
// alike, 0 where all y are
double StartSlope(std::span<const LinePoint> points) {
  const auto n = static_cast<double>(points.size());
  double mean_x = 0;
  double mean_y = 0;
  for (const LinePoint& point : points) {
    mean_x += point.x / n;
    mean_y += point.y / n;
  }
  double xx = 0;
  double xy = 0;
  for (const LinePoint& point : points) {
    xx += (point.x - mean_x) * (point.x - mean_x);
    xy += (point.x - mean_x) * (point.y - mean_y);
  }
  return xx > 0 ? xy / xx : 0;
}

template <typename Member>
bool AllAlike(std::span<const LinePoint> points, Member member) {
  const auto [least, most] = std::ranges::minmax(points, {}, member);
  return least.*member == most.*member;
}

std::unexpected<Error> OnNoLine() {
  return CannotAnswer("", "the points lie on no straight line",
                      "check the columns and their units");
}

}  // namespace

double StraightLine::UncertaintyAt(double x) const {
  return std::sqrt(std::max(0.0, intercept_uncertainty * intercept_uncertainty +
                                     x * x * slope_uncertainty * slope_uncertainty +
                                     2 * x * covariance));
}

Result<StraightLine> FitStraightLine(std::span<const LinePoint> points, Scatter scatter) {
  constexpr std::size_t kLeastPoints = 3;
  if (points.size() < kLeastPoints) {
    return CannotAnswer("", fmt::format("{} points", points.size()),
                        "a line with an uncertainty needs 3 or more");
  }
  if (AllAlike(points, &LinePoint::x) || AllAlike(points, &LinePoint::y)) {
    return CannotAnswer("", "all voltages or all displacements are the same",
                        "give points that lie apart");
  }

  // fixed point of the slope
  double slope = StartSlope(points);
  Step step;
  bool is_converged = false;
  for (int i = 0; i < kMostIterations && !is_converged; ++i) {
    step = StepAt(points, slope);
    if (!std::isfinite(step.slope) || step.slope == 0) return OnNoLine();
    is_converged = std::abs(step.slope - slope) <= kConverged * std::abs(step.slope);
    slope = step.slope;
  }
  // round-off of long tables may leave the last digits moving
  step = StepAt(points, slope);
  if (!is_converged && !(std::abs(step.slope - slope) <= 1e-9 * std::abs(slope))) return OnNoLine();

  StraightLine line{.slope = slope, .intercept = step.mean_y - slope * step.mean_x};
  double chi_square = 0;
  for (const LinePoint& point : points) {
    line.residuals.push_back(point.y - line.intercept - slope * point.x);
    chi_square += WeightOf(point, slope) * line.residuals.back() * line.residuals.back();
  }
  line.degrees_of_freedom = static_cast<int>(points.size()) - 2;
  line.birge_ratio = std::sqrt(chi_square / line.degrees_of_freedom);
  line.is_beyond_stated =
      scatter == Scatter::kStated &&
      chi_square > dsp::ChiSquareQuantile(kBeyondStated, line.degrees_of_freedom);

  // u(b)^2 = 1 / sum(W u^2), u(a)^2 = 1 / sum(W) + x^2 u(b)^2, cov = -x u(b)^2, times chi^2/(n-2)
  const bool is_scaled = scatter == Scatter::kFromResiduals || line.is_beyond_stated;
  const double factor = is_scaled ? line.birge_ratio * line.birge_ratio : 1;
  const double slope_variance = factor / step.adjusted_xx;
  line.slope_uncertainty = std::sqrt(slope_variance);
  line.intercept_uncertainty =
      std::sqrt(factor / step.weights + step.adjusted_x * step.adjusted_x * slope_variance);
  line.covariance = -step.adjusted_x * slope_variance;
  line.coverage_95 =
      is_scaled ? dsp::StudentCritical(line.degrees_of_freedom) : dsp::kNormalCritical;
  return line;
}

}  // namespace haptometer::fit
