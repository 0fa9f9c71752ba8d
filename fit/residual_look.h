#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace haptometer::fit {

/// What a sweep's residuals look like, in the order of frequency.
struct ResidualLook {
  /// Correlation of successive residuals, in deviations of that of white ones.
  double serial_correlation = 0;
  std::size_t farthest = 0;    ///< the point with the largest residual
  double farthest_spread = 0;  ///< that residual over 1.4826 times the median magnitude
};

/// Looks at residuals of several kinds, `points` of each one after the other. The median does not
/// follow a single bad point, as a standard deviation does (of 25 points none can lie more than 5
/// of their own deviations off).
[[nodiscard]] ResidualLook LookAtResiduals(const std::vector<double>& residuals,
                                           std::size_t points);

/// Sentences on what is doubtful: residuals that follow each other by more than 3.5 deviations (1
/// in 4000 white ones), a point that lies 8 spreads off. `cause` says what the former may be.
/// Nothing for residuals that are rounding (`noise` below 1e-9).
[[nodiscard]] std::vector<std::string> DoubtResiduals(const ResidualLook& look, double noise,
                                                      double farthest_hz, const std::string& cause);

}  // namespace haptometer::fit
