#pragma once

#include <cstddef>
#include <vector>

namespace haptometer::fit {

/// How dense the noise is at the resonance, against a white one of the same power.
struct ResidualDensity {
  /// Mean power density from 0.5 to 1.5 times the resonance over that of all frequencies: the
  /// factor on the fitted constants' variances. 1 for white noise; 2 or more behind a low-pass or
  /// with the correlated rounding of a record that has less noise than its converter's step.
  double ratio = 1;
  /// Whether the ratio lies above 1 by more than 2.33 of its own deviations (1 % of white records).
  bool is_coloured = false;
};

/// Reads the density off the periodogram of a fit's residuals.
///
/// A least-squares fit of an oscillation is moved only by the noise near its frequency: with a
/// density S there, its covariance is S/(s^2 dt) times the white one (two-sided S). The ratio's own
/// deviation is 1/sqrt(lines in the band); fewer than 8 lines, or a band beyond half the rate, give
/// 1.
///
/// @param residuals on a regular grid, 0 where there is no sample
[[nodiscard]] ResidualDensity DensityAt(const std::vector<double>& residuals, double step_s,
                                        double resonance_hz);

}  // namespace haptometer::fit
