#include "fit/force_constant.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace haptometer::fit {
namespace {

constexpr std::size_t kColumn = Index(Shared::kForceConstantSquared);
constexpr double kGaussian = 0.05;  // relative uncertainty of Km up to which its square is

double SquareSum(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return sum;
}

std::vector<double> SquareAlone(const DropTestRoad& road) {
  std::vector<double> weights(road.jacobian.columns, 0.0);
  weights[kColumn] = 1;
  return weights;
}

// half the interval of Km^2 on one side, given numbers included
double HalfWidth(const DropTestRoad& road, const DropTestModel& model, const Spread& spread,
                 int side, double coverage) {
  const double square = road.point.shared[kColumn];
  const bool is_gaussian = spread.statistical < 2 * kGaussian * square;
  const double statistical =
      is_gaussian ? coverage * spread.statistical
                  : road.consistency.decay_widening * ProfileWidth(road, model, side, coverage);
  return std::hypot(statistical, coverage * spread.given, coverage * spread.blur);
}

}  // namespace

double ProfileWidth(const DropTestRoad& road, const DropTestModel& model, int side,
                    double coverage) {
  constexpr int kMostFits = 12;
  constexpr double kNear = 0.01;
  std::vector<bool> is_free = UnknownColumns(model, road.problem);
  is_free[kColumn] = false;
  const double deviation = SpreadOf(road, model, SquareAlone(road)).statistical;
  const double least = SquareSum(road.problem.Residuals(road.point));
  double width = coverage * deviation;
  RingDownPoint point = road.point;
  for (int k = 0; k < kMostFits; ++k) {
    point.shared[kColumn] = road.point.shared[kColumn] + side * width;
    (void)road.problem.Minimise(is_free, &point);
    const double rise = SquareSum(road.problem.Residuals(point)) - least;
    // the root of the rise is nearly in proportion to the width
    const double reached = std::sqrt(std::max(rise, 0.0) / road.variance);
    if (std::abs(reached - coverage) < kNear * coverage) break;
    width *= std::clamp(coverage / std::max(reached, 1e-3), 0.5, 2.0);
  }
  return width;
}

FittedValue EvaluateForceConstant(const DropTestRoad& road, const DropTestModel& model) {
  const double square = road.point.shared[kColumn];
  const Spread spread = SpreadOf(road, model, SquareAlone(road));
  FittedValue value;
  value.unit = "N/A";
  const double scale = std::max(std::abs(square), spread.statistical);
  if (!road.solver.converged || spread.blur >= kMostBlur * scale) return value;
  const double below = HalfWidth(road, model, spread, -1, kCoverage95);
  value.determined = square > 0 && (road.uses_heights || square > below);
  if (!value.determined) {
    const double above = HalfWidth(road, model, spread, 1, kCoverage95);
    value.at_most = std::sqrt(std::max(square, 0.0) + above);
    return value;
  }
  value.value = std::sqrt(square);
  // d ln Km = d Km^2 / (2 Km^2)
  TakeRelative({.blur = spread.blur / (2 * square),
                .statistical = spread.statistical / (2 * square),
                .given = spread.given / (2 * square),
                .combined = spread.combined / (2 * square)},
               value);
  if (road.uses_heights) return value;
  value.lower = std::sqrt(square - below);
  value.upper = std::sqrt(square + HalfWidth(road, model, spread, 1, kCoverage95));
  return value;
}

}  // namespace haptometer::fit
