#pragma once

#include <complex>
#include <span>
#include <vector>

#include "base/error.h"
#include "dsp/spectrum/welch.h"

namespace haptometer::dsp {

/// A response at one frequency, in the second signal's unit over the first's.
struct ResponsePoint {
  double frequency_hz = 0;
  std::complex<double> response;
  double coherence = 0;             ///< 0 to 1
  double relative_uncertainty = 0;  ///< standard, of the magnitude; and of the phase in rad
};

/// The response from `drive` to `displacement` between two frequencies, by H1 = cross / drive.
///
/// Noise in the displacement averages out; noise in the drive channel lowers |H1| by its share of
/// the drive's power. Relative uncertainty sqrt((1 - c) / (c degrees of freedom)), c the coherence
/// (Bendat and Piersol, Random Data, 4th ed., 2010, 9.2.3: sqrt(1-c)/sqrt(2 c n)). A window of
/// length T widens a resonance of f0 and Q by about 1/T: T should be ten times Q / f0, or more.
/// Frequencies at which the drive holds less than 1e-10 of its greatest density are left out.
/// Errors: WelchSpectrum's; fewer than two segments (the coherence would always be 1).
[[nodiscard]] Result<std::vector<ResponsePoint>> MeasureResponse(
    std::span<const double> drive, std::span<const double> displacement,
    const WelchOptions& options, double lower_hz, double upper_hz);

/// The amplitude of a swept or stepped sine at the frequency it had at that time.
struct SweptPoint {
  double time_s = 0;  ///< from the first sample
  double frequency_hz = 0;
  double amplitude = 0;
};

/// Amplitude over frequency of a sweep whose drive was not recorded, from the analytic signal of
/// the band-passed displacement, in blocks of `periods` periods of `lower_hz`.
///
/// Frequency and amplitude: those of the sine that turns with a parabola fitted to the block's
/// phase. Blocks at the ends and outside of the two frequencies are left out. Taken for a constant
/// drive the points are a response; a sweep of a hertz per second shows a resonance late by up to a
/// Q / (pi f0) hertz (the two directions' mean does not). Ordered by time.
[[nodiscard]] std::vector<SweptPoint> SweptAmplitude(std::span<const double> displacement,
                                                     double rate_hz, double lower_hz,
                                                     double upper_hz, double periods = 2);

}  // namespace haptometer::dsp
