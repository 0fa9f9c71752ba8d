#pragma once

#include <complex>

namespace haptometer {

/// Sines, angles and roots of the plane, with the properties of base/elementary_functions.h: the
/// same bytes on every processor, C99's special values (Annex F, and G of complex numbers), errors
/// in ulp that are found, not proven.
///
/// Angles in rad of any size: below 2^23 they are reduced by pi/2 in three parts (W. J. Cody and W.
/// Waite, "Software manual for the elementary functions", 1980, p. 136), above by as many bits of
/// 2/pi as count (M. H. Payne and R. N. Hanek, "Radian reduction for trigonometric functions",
/// SIGNUM Newsletter 18 (1983), p. 19), which takes three times as long.

struct SineAndCosine {
  double sine = 0;
  double cosine = 0;
};

/// Error below 0.85 ulp.
[[nodiscard]] double Sin(double angle_rad);
/// Error below 0.85 ulp.
[[nodiscard]] double Cos(double angle_rad);
/// Both, the same doubles as of Sin and Cos.
[[nodiscard]] SineAndCosine SinCos(double angle_rad);
/// Error below 0.6 ulp.
[[nodiscard]] double Tan(double angle_rad);

/// The angle of the point (x, y) in rad, from -pi to pi; error below 0.55 ulp.
[[nodiscard]] double Atan2(double y, double x);

/// sqrt(x^2 + y^2); error below 0.87 ulp. No overflow where the result is finite.
[[nodiscard]] double Hypot(double x, double y);

/// Hypot of the parts.
[[nodiscard]] double Abs(const std::complex<double>& z);
/// Atan2 of the parts.
[[nodiscard]] double Arg(const std::complex<double>& z);
/// radius (cos angle + i sin angle); each part's error is below 0.95 ulp.
[[nodiscard]] std::complex<double> Polar(double radius, double angle_rad);
/// The root with a real part that is not negative; each part's error is below 0.55 ulp.
[[nodiscard]] std::complex<double> Sqrt(const std::complex<double>& z);

}  // namespace haptometer
