#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/band.h"
#include "base/error.h"

namespace haptometer::dsp {

/// What a section's numerator is: (1 - 1/z)^2, 1 - 1/z^2 or (1 + 1/z)^2.
enum class SectionKind : std::uint8_t { kHighPass, kBandPass, kLowPass };

/// A second-order section in delta form, with d[n] = y[n] - y[n-1]:
///
///   d[n] = d[n-1] - f d[n-1] - e y[n-1] + b m[n],   y[n] = y[n-1] + d[n]
///
/// m is the numerator's combination of inputs. e and f are small where the corners are far below
/// the rate; a direct form would hold 2 - e - f and 1 - f instead and lose their digits. Middleton
/// and Goodwin, Digital Control and Estimation, 1990 (delta operator).
struct DeltaSection {
  SectionKind kind = SectionKind::kHighPass;
  double e = 0;  ///< 1 + a1 + a2 of the direct form, > 0
  double f = 0;  ///< 1 - a2 of the direct form, 0 < f < 2
  double b = 0;  ///< factor of the numerator
};

/// A band-pass as a cascade of sections: high-pass sections first (an offset of any size leaves in
/// the first one), then the band-pass section that an odd order has in the middle, then low-pass.
/// The filter's gain is in its last section.
struct FilterDesign {
  int order = 0;  ///< 1 to 8: as many sections
  std::vector<DeltaSection> sections;
  double rate_hz = 0;
};

/// Which curve has -3 dB at the corners: one pass, or two passes (forward and backward) together.
enum class Corners : std::uint8_t { kEach, kWhole };

/// A Butterworth band-pass as it is asked for. `order` N gives 2 N poles: N sections.
struct BandPass {
  int order = 6;                      ///< 1 to 8
  double lower_hz = kDefaultLowerHz;  ///< > 0
  double upper_hz = kDefaultUpperHz;  ///< > lower_hz, < rate / 2
  Corners corners = Corners::kWhole;
};

inline constexpr int kHighestOrder = 8;

/// Designs the band-pass by the bilinear transform, s = (z - 1)/(z + 1), corners at tan(pi f/rate).
///
///   |H|^2 = 1 / (1 + |(s^2 + w0^2)/(bw s)|^(2N)),   s = j tan(pi f/rate)
///
/// w0^2 is the product and bw the difference of the two warped corners. Corners::kWhole divides bw
/// by (sqrt(2) - 1)^(1/2N) and keeps w0, so that |H|^2 is 1/sqrt(2) at both corners.
/// Only tan, sin, cos, sqrt and roots without cancellation are used: the response of the stored
/// sections is within 6e-15 of the formula for rates of 2 kHz to 10 MHz (tests).
/// Errors (Cause::kUsage): order outside 1..8, corners not in order or not positive, upper corner
/// at or above rate/2, rate not positive.
[[nodiscard]] Result<FilterDesign> DesignBandPass(const BandPass& band, double rate_hz);

/// The complex response of one pass of the stored sections at `frequency_hz` (any, up to rate/2).
///
/// What the filter really does, rounded coefficients included; evaluated without cancellation.
[[nodiscard]] std::complex<double> Response(const FilterDesign& design, double frequency_hz);

/// |Response|; two passes have its square.
[[nodiscard]] double Magnitude(const FilterDesign& design, double frequency_hz);

/// How fast the slowest pole decays: -ln |z| * rate, in 1/s.
[[nodiscard]] double SlowestDecayPerS(const FilterDesign& design);

}  // namespace haptometer::dsp
