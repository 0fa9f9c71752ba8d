#pragma once

#include <complex>
#include <span>

namespace haptometer::dsp {

/// A sine whose amplitude and phase change linearly over samples n = 0 .. N - 1:
///   x(n) = (a + a' u) cos(w (n - m)) + (b + b' u) sin(w (n - m)),   m = (N - 1) / 2,
///   u = (n - m) / (N / 2)
struct ChangingSine {
  std::complex<double> amplitude;  ///< a - i b
  std::complex<double> slope;      ///< a' - i b'
  double square_sum = 0;           ///< of the samples
  double residual_sum = 0;         ///< squares that the fit leaves
};

/// The least-squares fit at w = `step_rad` a sample, in (0, pi). An amplitude that rises and a
/// frequency that differs by a few parts of 1 / duration leave nothing.
///
/// About the middle cos and u sin are even, sin and u cos odd: two systems of two unknowns each.
/// Cost: one pass; no allocation. At least five samples.
[[nodiscard]] ChangingSine FitChangingSine(std::span<const double> samples, double step_rad);

}  // namespace haptometer::dsp
