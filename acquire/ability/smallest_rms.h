#pragma once

namespace haptometer::acquire {

/// A vibration's RMS in a band, told from the noise there by subtracting the noise's power, which
/// was measured with the drive off.
struct NoiseInBand {
  double rms_m = 0;           ///< of the noise in the band, > 0
  double bandwidth_hz = 0;    ///< of the band, over which the noise is flat; > 0
  double record_s = 0;        ///< length of the record, > 0
  double noise_record_s = 0;  ///< length of the record of the noise alone, > 0
};

/// Relative standard uncertainty of an RMS of `rms_m` (a tone, > 0), as a ratio:
///
///   u^2 = (1 + T/Tn + 2 q) / (4 B T q^2),   q = rms^2 / noise^2.
///
/// A mean square over T of noise with bandwidth B scatters by noise^2 / sqrt(B T) (chi-square with
/// 2 B T degrees of freedom; Bendat, Piersol: Random Data, sect. 8.2), that of the noise alone over
/// Tn likewise, and the product of tone and noise by noise * rms * sqrt(2 / (B T)); the RMS is the
/// root of their difference, so half of its relative scatter. Holds where u is small against 1.
[[nodiscard]] double RelativeUncertainty(const NoiseInBand& noise, double rms_m);

/// The smallest RMS in m whose relative standard uncertainty is `relative` (> 0): the root of the
/// equation above, q = (1 + sqrt(1 + (1 + T/Tn) s)) / s with s = 4 B T relative^2.
[[nodiscard]] double SmallestRms(const NoiseInBand& noise, double relative);

}  // namespace haptometer::acquire
