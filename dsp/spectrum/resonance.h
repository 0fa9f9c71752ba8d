#pragma once

#include <span>

#include "dsp/spectrum/frequency_response.h"

namespace haptometer::dsp {

/// A resonance with one degree of freedom, displacement over force or voltage:
///
///   H(f) = gain / (1 - (f/f0)^2 + j (f/f0) / Q)
///
/// Standard uncertainties, from the points' scatter about the curve with the points taken as
/// independent; NaN where converged is false.
struct Resonance {
  double frequency_hz = 0;  ///< f0, undamped
  double frequency_uncertainty_hz = 0;
  double quality_factor = 0;  ///< Q = 1 / (2 damping ratio)
  double quality_factor_uncertainty = 0;
  double gain = 0;                ///< |H(0)|
  double residual_share = 0;      ///< RMS of what the curve leaves, over the RMS of the points
  double degrees_of_freedom = 0;  ///< real values less parameters
  /// false ("not determined"): too few points, no curve found, or f0 outside of the frequencies.
  bool converged = false;
};

/// Fits the complex response, points by frequency: a gain of any phase, f0 and Q. A point weighs by
/// the median deviation of its own and four neighbours on either side, or by its own where that is
/// ten times as large; never below 1e-3 of its value, so that a few bins without noise do not
/// decide.
///
/// Levenberg and Marquardt's steps from one of the 32 highest points and its half-power width, and
/// 4 and 16 times that, each time from the point whose curve leaves least; the lowest minimum
/// counts. A constant delay beside the resonance is not in the model and shows in `residual_share`.
[[nodiscard]] Resonance FitResonance(std::span<const ResponsePoint> points);

/// The same from amplitudes alone, of a drive that was constant; every point counts alike.
[[nodiscard]] Resonance FitResonance(std::span<const SweptPoint> points);

}  // namespace haptometer::dsp
