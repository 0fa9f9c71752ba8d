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

/// Excludes points that chance may give: with m points and n independent segments, the coherence of
/// noise exceeds 1 - (0.05 / m)^(1 / (n - 1)) at any of them in 5 % of records (Bendat and Piersol,
/// 9.2). `segments` overlap by half, in Hann windows.
void KeepSignificant(std::vector<ResponsePoint>& points, double segments);

/// Every third frequency: a Hann window spreads noise over three bins.
[[nodiscard]] std::vector<ResponsePoint> IndependentPoints(std::span<const ResponsePoint> points,
                                                           double resolution_hz);

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

/// The longest run of blocks of `block_s` whose frequency changes by less than 1 / block from one
/// to the next.
[[nodiscard]] std::vector<SweptPoint> LongestSweep(const std::vector<SweptPoint>& points,
                                                   double block_s);

/// Median rate of the frequency of two points or more, in Hz/s.
[[nodiscard]] double SweepRate(std::span<const SweptPoint> points);

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
