#pragma once

#include <span>
#include <vector>

#include "dsp/filter/butterworth.h"

namespace haptometer::dsp {

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
