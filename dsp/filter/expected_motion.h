#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace haptometer::dsp {

/// Motion slower than a band at one end of a signal, such as a hand's drift and tremor, and how it
/// is expected to go on:
///
///   a + b t + sum over the sines of c cos(w t) + s sin(w t),   t in samples from the signal's
///   middle.
struct ExpectedMotion {
  struct Sine {
    double rad_per_sample = 0;
    double cosine = 0;
    double sine = 0;
  };

  double offset = 0;
  double slope = 0;
  std::vector<Sine> sines;
  double middle = 0;  ///< index of t = 0

  /// Its value at index `k`, also beyond the signal.
  [[nodiscard]] double At(double k) const;
  /// Its values at the `count` indices from `first` on, each within rounding of At.
  [[nodiscard]] std::vector<double> From(double first, std::size_t count) const;
};

/// Fewest samples that FitExpectedMotion takes.
inline constexpr std::size_t kLeastExpectedMotionSamples = 128;
/// The fastest sine that it looks for turns by this over the signal.
inline constexpr double kFastestExpectedRad = 60;

/// Fits it by least squares to the means of 64 equal pieces, which keep faster motion out, with
/// `sines` (1 or 2) sines, each where the residual is least, of 2 to 60 rad over the signal. At
/// least kLeastExpectedMotionSamples. Cost: 0.5 ms, 3 ms with two.
[[nodiscard]] ExpectedMotion FitExpectedMotion(std::span<const double> signal, int sines);

}  // namespace haptometer::dsp
