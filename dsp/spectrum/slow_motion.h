#pragma once

#include <optional>
#include <span>

namespace haptometer::dsp {

/// Where tremor of a hand lies.
inline constexpr double kTremorLower_hz = 3;
inline constexpr double kTremorUpper_hz = 13;

/// Motion below the band of a vibration: of the hand, the skin or the sensor's mounting.
struct SlowMotion {
  double drift_per_s = 0;              ///< slope of the least-squares line through eight means
  double drift_uncertainty_per_s = 0;  ///< standard, with 6 degrees of freedom
  /// RMS between 3 and 13 Hz; nothing where the record is shorter than 1 s or its rate below 52 Hz.
  std::optional<double> tremor_rms;
  /// Standard, of a random tremor with this spectrum; with (rms/uncertainty)^2 / 2 degrees of
  /// freedom.
  double tremor_rms_uncertainty = 0;
  double tremor_frequency_hz = 0;  ///< the power's centre between 3 and 13 Hz
};

/// Drift and tremor of a low-rate signal (means of cells, at about 50 to 1000 Hz).
///
/// The drift's uncertainty is that of eight batch means (Law and Kelton, Simulation Modeling and
/// Analysis, 3rd ed., 2000, 9.5.3): motion that is independent from one eighth of the record to the
/// next is in it, whatever its spectrum. Tremor is measured after the line is taken off, in Welch's
/// Hann spectrum of segments of at most 4 s. Nothing for fewer than 16 samples, or values that are
/// not finite.
[[nodiscard]] std::optional<SlowMotion> DescribeSlowMotion(std::span<const double> signal,
                                                           double rate_hz);

}  // namespace haptometer::dsp
