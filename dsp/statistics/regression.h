#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "dsp/statistics/distributions.h"

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

/// Points that belong together; x and y are of one length.
struct Points {
  std::vector<double> x;
  std::vector<double> y;
};

/// The one slope of groups that each have a level of their own (analysis of covariance):
///   sum (x - mean x)(y - mean y) / sum (x - mean x)^2,   means of each group
/// Nothing where no group has two different x. Cost: one pass; no allocation.
[[nodiscard]] std::optional<double> SlopeWithinGroups(std::span<const Points> groups);

/// How far points bend: c of the least-squares parabola y = a + b x + c x^2.
struct Curvature {
  std::size_t n = 0;
  double quadratic = 0;    ///< c, in y's unit over x's squared
  Interval interval = {};  ///< of c
  double df = 0;           ///< n - 3
  /// Of c against 0, two-sided; nothing where the parabola goes through all points exactly.
  std::optional<double> t = {};
  std::optional<double> p = {};
};

/// With q what a line over x leaves of (x - mean x)^2:
///   c = sum(q y) / sum(q^2),   t = c sqrt(sum(q^2)) / s,   s^2 = residual sum of squares / (n - 3)
/// (Frisch and Waugh, Econometrica 1(4), 1933). Exact for normal deviations of equal spread.
/// Nothing with fewer than 4 points or 3 different x.
[[nodiscard]] std::optional<Curvature> FitCurvature(std::span<const double> x,
                                                    std::span<const double> y);

}  // namespace haptometer::dsp
