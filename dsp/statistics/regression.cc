#include "dsp/statistics/regression.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "dsp/statistics/distributions.h"
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

}  // namespace

std::optional<Line> FitLine(std::span<const double> x, std::span<const double> y) {
  HAPTOMETER_CHECK(x.size() == y.size(), "{} and {} values", x.size(), y.size());
  if (x.size() < 3) return std::nullopt;
  const auto n = static_cast<double>(x.size());
  const double mean_x = Mean(x);
  const double mean_y = Mean(y);
  const Sums sums = SumsOf(x, y, mean_x, mean_y);
  if (!(sums.xx > 0)) return std::nullopt;

  Line line{.n = x.size()};
  line.slope = sums.xy / sums.xx;
  line.intercept = mean_y - line.slope * mean_x;
  double residual = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double off = (y[i] - mean_y) - line.slope * (x[i] - mean_x);
    residual += off * off;
    line.largest_deviation = std::max(line.largest_deviation, std::abs(off));
  }
  line.r_squared = sums.yy > 0 ? 1 - residual / sums.yy : 1;
  line.residual_deviation = std::sqrt(residual / (n - 2));
  const double critical = StudentCritical(n - 2) * line.residual_deviation;
  const double slope_reach = critical / std::sqrt(sums.xx);
  const double intercept_reach = critical * std::sqrt(1 / n + mean_x * mean_x / sums.xx);
  line.slope_interval = {line.slope - slope_reach, line.slope + slope_reach};
  line.intercept_interval = {line.intercept - intercept_reach, line.intercept + intercept_reach};
  return line;
}

}  // namespace haptometer::dsp
