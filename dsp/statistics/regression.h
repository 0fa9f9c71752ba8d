#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "dsp/statistics/interval.h"

namespace haptometer::dsp {

/// A least-squares line y = intercept + slope x.
struct Line {
  std::size_t n = 0;
  double slope = 0;
  double intercept = 0;
  Interval slope_interval = {};
  Interval intercept_interval = {};
  double r_squared = 0;           ///< 1 - residual / total sum of squares; 1 where y is constant
  double residual_deviation = 0;  ///< sqrt(residual sum of squares / (n - 2)), in y's unit
  double largest_deviation = 0;   ///< max |y - line|, in y's unit
};

/// Ordinary least squares with Student's intervals (n - 2 degrees of freedom): exact for normal
/// deviations of equal spread. Nothing with fewer than 3 points or equal x.
[[nodiscard]] std::optional<Line> FitLine(std::span<const double> x, std::span<const double> y);

}  // namespace haptometer::dsp
