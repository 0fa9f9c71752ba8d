#pragma once

#include <span>
#include <vector>

#include "base/error.h"
#include "dsp/filter/butterworth.h"

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

/// Convolves a signal with symmetric taps (odd in number) without delay:
///   y[n] = sum over k of taps[k] x[n + M - k], M = (taps.size() - 1)/2, x = 0 beyond the ends.
///
/// By overlap-save: blocks of 4 to 8 times the taps, FFTW. Returns signal.size() samples; the first
/// and last M hang on what lay beyond the ends. Rounding: 1e-16 of the largest output times the
/// logarithm of a block's size, everywhere: an offset of 30 mm costs a 1 um tone 5 digits, unlike
/// in the cascades. Threads may call it.
[[nodiscard]] std::vector<double> FilterByOverlapSave(std::span<const double> taps,
                                                      std::span<const double> signal);

/// The zero-phase filter of `design` in the frequency domain: one FFT over the signal, continued
/// oddly by its ringing, times |Response|^2, and back.
///
/// Needs memory of four times the signal, and no block can be made without all others; offset and
/// drift are lost in the FFT's rounding as above.
[[nodiscard]] std::vector<double> FilterByFft(const FilterDesign& design,
                                              std::span<const double> signal);

}  // namespace haptometer::dsp
