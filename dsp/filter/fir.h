#pragma once

#include <vector>

#include "base/error.h"

namespace haptometer::dsp {

/// A linear-phase band-pass as it is asked for: the alternative to the Butterworth filters.
struct FirBandPass {
  double lower_hz = 20;        ///< middle of the lower transition, > transition_hz / 2
  double upper_hz = 500;       ///< middle of the upper one, above lower_hz, < rate / 2
  double transition_hz = 10;   ///< width of each transition, > 0
  double attenuation_db = 60;  ///< of the stop bands, and ripple of the pass band; 21 to 200
};

/// Designs it as a windowed sinc with Kaiser's window; the taps are symmetric and odd in number.
///
///   h[n] = (sin(w2 n) - sin(w1 n)) / (pi n) I0(beta sqrt(1 - (n/M)^2)) / I0(beta), |n| <= M,
///   beta = 0.1102 (A - 8.7) above 50 dB, 0.5842 (A - 21)^0.4 + 0.07886 (A - 21) below,
///   2 M >= (A - 7.95) / (2.285 x 2 pi transition/rate).
///
/// Kaiser, Nonrecursive digital filter design using the I0-sinh window function, ISCAS 1974;
/// Oppenheim and Schafer, Discrete-Time Signal Processing, 3rd ed., 7.6. Errors (Cause::kUsage):
/// corners, width or attenuation not as above, or more than 2^26 taps.
[[nodiscard]] Result<std::vector<double>> DesignFirBandPass(const FirBandPass& band,
                                                            double rate_hz);

}  // namespace haptometer::dsp
