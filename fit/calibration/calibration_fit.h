#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/error.h"
#include "fit/calibration/outliers.h"
#include "fit/calibration/straight_line.h"

namespace haptometer::fit {

/// The difference of readings that were approached from below and from above.
struct Hysteresis {
  double difference = 0;  ///< mean residual of rising points less that of falling ones, in y's unit
  double standard_uncertainty = 0;
  bool is_significant = false;  ///< beyond three standard uncertainties
};

/// A step between two points, in the order in which they were measured: a target that slipped.
struct Slip {
  std::size_t point = 0;  ///< the first behind it
  double step = 0;        ///< of y, behind it less before it
  double slope = 0;       ///< of the two parallel lines
};

/// A calibration line and how well its points keep to it; y is the reference (m), x the input (V).
struct CalibrationFit {
  StraightLine line;
  /// Largest distance of a point from the line in y, and which point has it.
  double nonlinearity = 0;
  std::size_t farthest = 0;
  /// Of each point: 1 where y rose to it from the point before, -1 where it fell, 0 for the first.
  std::vector<int> directions;
  /// Nothing without two points of each direction.
  std::optional<Hysteresis> hysteresis;
  /// Points that lie too far from the line of the others, of four points at least. They are points
  /// of a curve, and none of these, where a cubic through all points explains the residuals better
  /// than chance does (F test, level 1 %), leaves less than ten times the variance that the line of
  /// the others does, and differs in slope by 5 % at most (RMS over the range). The line holds
  /// them.
  std::optional<Outliers> outliers;
  /// Whether a cubic explains the residuals better than chance does: F test of the quadratic and
  /// cubic terms, level 1 %; of six points at least, without outliers.
  bool is_curved = false;
  /// Nothing unless two parallel lines, of two points each at least, leave less than one line does
  /// (F test of the best of all steps, each at the level 1 % over their number) and than a cubic;
  /// of six points at least, without outliers and hysteresis. The line holds all points.
  std::optional<Slip> slip;
  /// Relative standard uncertainty by which the slope within the range differs from the line's:
  /// RMS over the range of the cubic's slope less the line's; 0 unless curved.
  double local_slope_uncertainty = 0;
  /// Relative standard uncertainty of the slope of a small motion anywhere in the range,
  ///   hypot(coverage u(b) / (1.96 |b|), local slope),
  /// which, times 1.96, gives the 95 % interval for any number of points.
  double relative_uncertainty = 0;
};

/// Fits the line through `points` in the order in which they were measured. Errors: as
/// FitStraightLine.
[[nodiscard]] Result<CalibrationFit> FitCalibration(std::span<const LinePoint> points,
                                                    Scatter scatter);

/// The normalised error of two results (k = 2; ISO 13528, 9.7):
///   E_n = (a - b) / sqrt((2 u(a))^2 + (2 u(b))^2)
/// They disagree where |E_n| > 1. Nothing where they differ and both are exact, to rounding (1e-12
/// of the larger).
[[nodiscard]] std::optional<double> NormalizedError(double a, double a_uncertainty, double b,
                                                    double b_uncertainty);

}  // namespace haptometer::fit
