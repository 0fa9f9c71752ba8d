#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

namespace haptometer::fit {

/// A pair of poles as the polynomial s^2 + 2 decay s + stiffness, which stays well conditioned when
/// the poles coalesce.
struct PolePair {
  double decay_per_s = 0;
  double stiffness_per_s2 = 0;
};

/// The strongest oscillation's frequency in Hz, from the largest line of the zero-padded spectrum
/// above two periods a record (FFTW); a start value, good to half a line. Nothing for less than 16
/// samples or a constant record.
[[nodiscard]] std::optional<double> StrongestFrequency(const std::vector<double>& values,
                                                       double step_s);

/// Start values of one damped oscillation by the matrix pencil.
///
/// The record is averaged in blocks down to about 8 samples a period and at most 240 samples; of
/// its Hankel matrix (N - L) x (L + 1), L = N/3, the two leading right singular vectors V span the
/// signal, and the poles' powers z are the eigenvalues of V1^+ V2 (V without its last and its first
/// row); trace and determinant of that 2 x 2 matrix give the polynomial, so a double pole is not
/// special. Y. Hua, T. K. Sarkar, IEEE Trans. ASSP 38 (1990) 814-824. Efficient to about 1.1 of the
/// Cramer-Rao bound with five periods or more; the offset must be gone.
///
/// Where noise gives growing or absent poles: the spectrum's frequency with Q = 30.
/// Cost: one SVD of at most 160 x 81, about 1 ms, and one FFT.
[[nodiscard]] std::optional<PolePair> EstimatePoles(const std::vector<double>& values,
                                                    double step_s);

/// The pole of an oscillation in the plane that people draw, decay rate over damped frequency, with
/// the covariance of the two.
struct UncertainPole {
  double frequency_hz = 0;  ///< damped, > 0
  double decay_per_s = 0;
  /// Of frequency and decay, in this order: Hz^2, Hz/s, 1/s^2.
  std::array<std::array<double, 2>, 2> covariance{};
  /// False where it does not oscillate, or the records do not tell it; then nothing else holds.
  bool determined = false;
};

/// A place in that plane.
struct PolePlace {
  double frequency_hz = 0;
  double decay_per_s = 0;
};

/// Outline of the region that holds both numbers together in 95 of 100 cases: the points at
/// Mahalanobis distance sqrt(-2 ln 0.05) = 2.448 (chi-squared of two degrees of freedom),
///
///     place = pole + 2.448 L (cos a, sin a),   L L' = covariance.
///
/// `points` >= 3 places, the first one repeated at the end. Half its width along an axis is 2.448
/// standard deviations, not the 1.96 of a single number's interval.
[[nodiscard]] std::vector<PolePlace> EllipseOf(const UncertainPole& pole, std::size_t points);

}  // namespace haptometer::fit
