#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/filter/butterworth.h"

/// Hum of the mains: tones at 50 or 60 Hz and its multiples that are there whether the drive is.
namespace haptometer::dsp {

/// A sine of steady frequency that is there all the time and is no drive.
struct SteadyLine {
  double frequency_hz = 0;
  double cosine_m =
      0;  ///< cosine_m cos(2 pi f t) + sine_m sin(2 pi f t), t from the segment's first
  double sine_m = 0;

  [[nodiscard]] double amplitude_m() const;
};

/// Adds the sum of `lines` to nothing: its value at time `t_s` from the segment's first sample.
[[nodiscard]] double ValueOf(std::span<const SteadyLine> lines, double t_s);

/// The hum in a segment, the fundamental first; empty where there is none.
///
/// The fundamental is sought within 0.06 Hz of 50 and of 60 Hz, its multiples up to the tenth
/// within the band. A line z is the mean of demodulated windows of half the segment (20 s at most),
/// each tapered (Blackman and Harris), so that a drive eight bins away does not reach it; the
/// windows' phases give its frequency. It is hum where z exceeds five times what noise gives and
/// every window lies within 0.3 |z| of it: a drive that is switched does not. A multiple must not
/// exceed the fundamental: a drive at 100 Hz beside weak hum is no hum. Below 1 s, and beyond 2^21
/// values, nothing is sought. Errors: as BandSignal::Read. Cost: 20 flops a value and line.
[[nodiscard]] Result<std::vector<SteadyLine>> FindHum(const BandSignal& signal,
                                                      const BandPass& band);

}  // namespace haptometer::dsp
