#pragma once

#include <cstddef>
#include <span>

namespace haptometer::dsp {

/// Motion slower than a band at one end of a signal, such as a hand's drift and tremor, and how it
/// is expected to go on: a + b t + c cos(w t) + s sin(w t), t in samples from the signal's middle.
struct ExpectedMotion {
  double rad_per_sample = 0;
  double offset = 0;
  double slope = 0;
  double cosine = 0;
  double sine = 0;
  double middle = 0;  ///< index of t = 0

  /// Its value at index `k`, also beyond the signal.
  [[nodiscard]] double At(double k) const;
};

/// Fewest samples that FitExpectedMotion takes.
inline constexpr std::size_t kLeastExpectedMotionSamples = 128;

/// Fits it by least squares to the means of 64 equal pieces, which keep faster motion out; w where
/// the residual is least, of 2 to 60 rad over the signal. At least kLeastExpectedMotionSamples.
[[nodiscard]] ExpectedMotion FitExpectedMotion(std::span<const double> signal);

}  // namespace haptometer::dsp
