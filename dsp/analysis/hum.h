#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/filter/butterworth.h"

/// Hum of the mains: tones at 50 or 60 Hz and its multiples that are there whether the drive is.
namespace haptometer::dsp {

/// Mains frequencies.
inline constexpr std::array<double, 2> kMainsHz{50, 60};

/// Whether a frequency is 50 or 60 Hz or a multiple of one, to `tolerance_hz`.
[[nodiscard]] bool IsOfMains(double frequency_hz, double tolerance_hz);

/// A sine of steady frequency that is there all the time and is no drive.
struct SteadyLine {
  double frequency_hz = 0;
  double cosine_m =
      0;  ///< cosine_m cos(2 pi f t) + sine_m sin(2 pi f t), t from the segment's first
  double sine_m = 0;

  [[nodiscard]] double amplitude_m() const;
};

/// Subtracts `lines` from `samples` at `rate_hz`, the first of them sample number `first`, at that
/// rate, of the segment.
void SubtractLines(std::span<const SteadyLine> lines, double rate_hz, double first,
                   std::span<double> samples);

/// The hum in a segment, the fundamental first; empty where there is none.
///
/// The fundamental is sought within 0.06 Hz of 50 and of 60 Hz, its multiples up to the tenth
/// within the band. A line z is the mean of demodulated windows of half the segment (20 s at most),
/// each tapered (Blackman and Harris), so that a drive eight of their bins away (4 Hz for 4 s) does
/// not reach it; the windows' phases give its frequency. It is hum where z exceeds five times what
/// noise gives and each of many short windows (a quarter of a second, or a sixteenth of the
/// segment) lies within half of |z| and its own noise of it: a drive that is switched does not. A
/// drive within 16 Hz, or 64 divided by the duration, reaches the short windows: hum there is not
/// claimed. A multiple must not exceed the fundamental: a drive at 100 Hz beside weak hum is no
/// hum. Where `stated_hz`, the drive's known frequency, is a multiple of 50 or 60 Hz to 1 Hz, that
/// mains is not sought. Below 1 s, and beyond 2^21 values, nothing is sought. Errors: as
/// BandSignal::Read. Cost: 20 flops a value and line.
[[nodiscard]] Result<std::vector<SteadyLine>> FindHum(const BandSignal& signal,
                                                      const BandPass& band,
                                                      std::optional<double> stated_hz);

}  // namespace haptometer::dsp
