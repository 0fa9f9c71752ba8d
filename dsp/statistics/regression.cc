#include "dsp/statistics/regression.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

// sums over the deviations from the means
struct Sums {
  double xx = 0;
  double xy = 0;
  double yy = 0;
};

Sums SumsOf(std::span<const double> x, std::span<const double> y, double mean_x, double mean_y) {
  Sums sums;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sums.xx += (x[i] - mean_x) * (x[i] - mean_x);
    sums.xy += (x[i] - mean_x) * (y[i] - mean_y);
    sums.yy += (y[i] - mean_y) * (y[i] - mean_y);
  }
  return sums;
}

// residuals about the means, where offsets of x and y cost no digits
std::vector<double> ResidualsOf(const Line& line, std::span<const double> x,
                                std::span<const double> y) {
  const double mean_x = Mean(x);
  const double mean_y = Mean(y);
  std::vector<double> residuals(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    residuals[i] = (y[i] - mean_y) - line.slope * (x[i] - mean_x);
  }
  return residuals;
}

}  // namespace

std::optional<Line> FitLine(std::span<const double> x, std::span<const double> y) {
  HAPTOMETER_CHECK(x.size() == y.size(), "{} and {} values", x.size(), y.size());
  if (x.size() < 3) return std::nullopt;
  const auto n = static_cast<double>(x.size());
  const double mean_x = Mean(x);
  const double mean_y = Mean(y);
  const Sums sums = SumsOf(x, y, mean_x, mean_y);
  if (!(sums.xx > 0)) return std::nullopt;

  // slope = sum xy / sum xx; the line passes through the means
  Line line{.n = x.size()};
  line.slope = sums.xy / sums.xx;
  line.intercept = mean_y - line.slope * mean_x;
  double residual = 0;
  // residual variance with n - 2 degrees of freedom
  for (const double off : ResidualsOf(line, x, y)) {
    residual += off * off;
    line.largest_deviation = std::max(line.largest_deviation, std::abs(off));
  }
  line.r_squared = sums.yy > 0 ? 1 - residual / sums.yy : 1;
  line.residual_deviation = std::sqrt(residual / (n - 2));
  // u(slope) = s / sqrt(xx), u(intercept) = s sqrt(1/n + mean_x^2 / xx)
  const double critical = StudentCritical(n - 2) * line.residual_deviation;
  const double slope_reach = critical / std::sqrt(sums.xx);
  const double intercept_reach = critical * std::sqrt(1 / n + mean_x * mean_x / sums.xx);
  line.slope_interval = {line.slope - slope_reach, line.slope + slope_reach};
  line.intercept_interval = {line.intercept - intercept_reach, line.intercept + intercept_reach};
  return line;
}

// deviations from each group's own means, so that levels of groups do not matter
std::optional<double> SlopeWithinGroups(std::span<const Points> groups) {
  double xx = 0;
  double xy = 0;
  for (const Points& group : groups) {
    HAPTOMETER_CHECK(group.x.size() == group.y.size(), "{} x and {} y", group.x.size(),
                     group.y.size());
    if (group.x.size() < 2) continue;
    const double mean_x = Mean(group.x);
    const double mean_y = Mean(group.y);
    for (std::size_t i = 0; i < group.x.size(); ++i) {
      xx += (group.x[i] - mean_x) * (group.x[i] - mean_x);
      xy += (group.x[i] - mean_x) * (group.y[i] - mean_y);
    }
  }
  return xx > 0 ? std::optional(xy / xx) : std::nullopt;
}

std::optional<Curvature> FitCurvature(std::span<const double> x, std::span<const double> y) {
  const auto line = FitLine(x, y);
  if (!line || x.size() < 4) return std::nullopt;
  // q: the part of (x - mean)^2 that no line over x explains
  const double mean_x = Mean(x);
  std::vector<double> squares(x.size());
  std::ranges::transform(x, squares.begin(),
                         [&](double value) { return (value - mean_x) * (value - mean_x); });
  const std::vector<double> bends = ResidualsOf(*FitLine(x, squares), x, squares);
  const std::vector<double> left = ResidualsOf(*line, x, y);
  const double bent = Rms(bends) * Rms(bends);
  // with two different x, a line explains all of the squares but rounding
  if (!(std::sqrt(bent) > 1e-12 * Rms(squares))) return std::nullopt;

  // c = sum(q y) / sum(q^2), with the line already removed from y
  const auto n = static_cast<double>(x.size());
  Curvature curvature{.n = x.size(), .df = n - 3};
  for (std::size_t i = 0; i < x.size(); ++i) curvature.quadratic += bends[i] * left[i] / (n * bent);
  double residual = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double off = left[i] - curvature.quadratic * bends[i];
    residual += off * off;
  }
  // u(c) = s / sqrt(sum(q^2)), s^2 with n - 3 degrees of freedom
  const double uncertainty = std::sqrt(residual / curvature.df / (n * bent));
  const double reach = StudentCritical(curvature.df) * uncertainty;
  curvature.interval = {curvature.quadratic - reach, curvature.quadratic + reach};
  if (uncertainty > 0) {
    curvature.t = curvature.quadratic / uncertainty;
    curvature.p = StudentTwoSidedP(*curvature.t, curvature.df);
  }
  return curvature;
}

}  // namespace haptometer::dsp
