#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace haptometer::fit {

/// The pole of an oscillation in the plane that people draw, decay rate over damped frequency, with
/// the covariance of the two.
struct UncertainPole {
  double frequency_hz = 0;  ///< damped, > 0
  double decay_per_s = 0;
  /// Of frequency and decay, in this order: Hz^2, Hz/s, 1/s^2.
  std::array<std::array<double, 2>, 2> covariance{};
  /// False where it does not oscillate, or the records do not tell it; then nothing else holds.
  bool determined = false;
};

/// A place in that plane.
struct PolePlace {
  double frequency_hz = 0;
  double decay_per_s = 0;
};

/// Outline of the region that holds both numbers together in 95 of 100 cases: the points at
/// Mahalanobis distance sqrt(-2 ln 0.05) = 2.448 (chi-squared of two degrees of freedom),
///
///     place = pole + 2.448 L (cos a, sin a),   L L' = covariance.
///
/// `points` >= 3 places, the first one repeated at the end. Half its width along an axis is 2.448
/// standard deviations, not the 1.96 of a single number's interval.
[[nodiscard]] std::vector<PolePlace> EllipseOf(const UncertainPole& pole, std::size_t points);

}  // namespace haptometer::fit
