#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/error.h"

namespace haptometer::dsp {

/// Windows for spectra, with what Heinzel, Ruediger and Schilling (Spectrum and spectral density
/// estimation by the DFT, 2002, appendices C and D) state of them: equivalent noise bandwidth in
/// bins, greatest amplitude error of a tone between two bins, highest side lobe, recommended
/// overlap.
enum class WindowShape : std::uint8_t {
  kRectangular,     ///< 1.0000, -3.92 dB, -13.3 dB, 0 %: tones of whole periods only
  kHann,            ///< 1.5000, -1.42 dB, -31.5 dB, 50 %: the usual one
  kHamming,         ///< 1.3628, -1.75 dB, -42.7 dB, 50 %
  kBlackmanHarris,  ///< 2.0044, -0.83 dB, -92.0 dB, 66.1 %: small tones beside large ones
  kFlatTop,         ///< HFT90D: 3.8832, -0.0039 dB, -90.2 dB, 76 %: a tone's amplitude
};

/// The window of `size` >= 1 values in its periodic form: a sum of cosines of 2 pi n / size.
[[nodiscard]] std::vector<double> WindowValues(WindowShape shape, std::size_t size);

/// size sum(w^2) / (sum w)^2: the width in bins of the rectangle that passes as much noise.
[[nodiscard]] double NoiseBandwidthBins(const std::vector<double>& window);

/// What is taken off each segment before its transform.
enum class Detrend : std::uint8_t { kNothing, kMean };

/// How a signal is cut into segments and transformed.
struct WelchOptions {
  double rate_hz = 0;
  std::size_t segment_size = 0;  ///< samples; the resolution is rate / segment_size
  WindowShape window = WindowShape::kHann;
  double overlap = 0.5;  ///< share of a segment that the next one repeats, 0 to below 1
  Detrend detrend = Detrend::kMean;
};

/// What every averaged spectrum says of itself.
struct SpectrumGrid {
  double resolution_hz = 0;       ///< bin k lies at k times this
  double noise_bandwidth_hz = 0;  ///< of the window (ENBW)
  std::size_t segments = 0;
  /// Of a bin's power: 2 segments, less what overlapping ones have in common.
  double degrees_of_freedom = 0;
  /// Times these factors a bin's power becomes the ends of a 95 % interval for the true one.
  double lower_factor = 0;
  double upper_factor = 0;
};

/// One-sided power spectral density: the mean square is the sum of density x resolution.
struct PowerSpectrum {
  SpectrumGrid grid;
  std::vector<double> density;  ///< (bins), unit^2/Hz
};

/// Two signals' densities and what they have in common.
struct CrossSpectrum {
  SpectrumGrid grid;
  std::vector<double> from_density;         ///< (bins), of the first signal
  std::vector<double> to_density;           ///< (bins), of the second
  std::vector<std::complex<double>> cross;  ///< (bins), conj(first) second, one-sided
};

/// Welch's averaged spectrum (IEEE Transactions on Audio and Electroacoustics 15(2), 1967, p. 70).
///
///   density[k] = c_k / (rate sum w^2) mean over segments of |sum_n w[n] x[n] exp(-2 pi j k n/M)|^2
///
/// c_k is 2, and 1 for k = 0 and rate/2. With segments of correlation r_m = (sum w[n] w[n + m step]
/// / sum w^2)^2, degrees of freedom = 2 K / (1 + 2 sum over m < K of (1 - m/K) r_m) (Welch, eq. 15;
/// Percival and Walden, Spectral Analysis for Physical Applications, 1993, eq. 292b), half of them
/// at k = 0 and rate/2; the 95 % interval is chi-squared's, for noise that is smooth over a
/// window's bandwidth. Sums over segments are pairwise. Segments that reach over the end are left
/// out. Errors (Cause::kUsage): segment_size below 2, above the signal or 2^30, overlap outside [0,
/// 1), values that are not finite. Cost: one transform a segment; memory: log2(segments) spectra.
[[nodiscard]] Result<PowerSpectrum> WelchSpectrum(std::span<const double> signal,
                                                  const WelchOptions& options);

/// Densities and cross-density of two signals of one size, sampled together; as WelchSpectrum.
[[nodiscard]] Result<CrossSpectrum> WelchCrossSpectrum(std::span<const double> from,
                                                       std::span<const double> to,
                                                       const WelchOptions& options);

/// |cross|^2 / (from to): 1 where one signal follows the other linearly, on average
/// 2 / degrees_of_freedom where they have nothing in common; NaN where one of them is nothing.
[[nodiscard]] std::vector<double> Coherence(const CrossSpectrum& spectrum);

/// Amplitude (not RMS) of a sine that each bin would stand for: sqrt(2 density ENBW), and
/// sqrt(density ENBW) at 0. Right for a tone on a bin, and by the window's amplitude error
/// otherwise; noise reads sqrt(ENBW) times its density.
[[nodiscard]] std::vector<double> AmplitudeSpectrum(const PowerSpectrum& spectrum);

/// RMS of what lies from `lower_hz` to `upper_hz`: the density's sum, bins at the ends by the share
/// of them that lies inside. A tone's power spreads over the window's main lobe: leave its bins
/// room.
[[nodiscard]] double RmsWithin(const PowerSpectrum& spectrum, double lower_hz, double upper_hz);

/// Power over time and frequency.
struct Spectrogram {
  double resolution_hz = 0;                  ///< bin k lies at k times this
  double noise_bandwidth_hz = 0;             ///< of the window (ENBW)
  double start_s = 0;                        ///< middle of the first segment, from the first sample
  double step_s = 0;                         ///< between segments
  std::vector<std::vector<double>> density;  ///< (segments, bins), one-sided, unit^2/Hz
};

/// The spectrum of each segment by itself: the mean over time is WelchSpectrum's density.
///
/// Segments, scaling and errors are WelchSpectrum's; a segment longer than a change smears it.
[[nodiscard]] Result<Spectrogram> MakeSpectrogram(std::span<const double> signal,
                                                  const WelchOptions& options);

}  // namespace haptometer::dsp
