#pragma once

#include "base/double_double.h"

namespace haptometer {

/// Elementary functions that give the same bytes on every processor and with every compiler.
///
/// The C library's do not: glibc has variants with fused products, chosen when a program begins.
/// These consist of sums, products, quotients and square roots of IEEE doubles in round-to-nearest,
/// of operations on their bits and of constant tables, and call nothing else. Special values (zeros
/// with their sign, subnormals, infinities, NaN, overflow, underflow) are those of C99, Annex F;
/// errno and the floating-point flags are not set on purpose. The stated error, a part of a unit in
/// the last place (ulp), is the largest that MPFR finds in 1e4 to 1e5 arguments of all sizes (of
/// Erfc in 1e3), with a margin: neither it nor monotony is proven. No function allocates or throws.
///
/// Method: a table's value next to the argument, and a polynomial of the rest; sums whose rounding
/// would be seen carry a second double. Source: P. T. P. Tang, "Table-driven implementation of the
/// exponential function in IEEE floating-point arithmetic", ACM TOMS 15 (1989), p. 144, and "... of
/// the logarithm function ...", ACM TOMS 16 (1990), p. 378. Coefficients:
/// tests/base/reference/elementary_tables.py. Cost: bench/elementary_functions_bench.cc.

/// e^x; error below 0.52 ulp.
[[nodiscard]] double Exp(double x);

/// e^x - 1; error below 0.7 ulp.
[[nodiscard]] double Expm1(double x);

/// The natural logarithm; error below 0.52 ulp. NaN below 0, -inf at 0.
[[nodiscard]] double Log(double x);

/// log(1 + x); error below 0.53 ulp. NaN below -1, -inf at -1.
[[nodiscard]] double Log1p(double x);

/// The decadic logarithm; error below 0.51 ulp, and none at powers of ten. NaN below 0, -inf at 0.
[[nodiscard]] double Log10(double x);

/// x^y; error below 0.65 ulp, and none where x^y is a double. NaN for x < 0 unless y is whole.
[[nodiscard]] double Pow(double x, double y);

/// scale base^exponent, of which only the end is rounded: error below 0.6 ulp where base^exponent
/// is between 1e-30 and 1e30. `scale` and `base` are positive and normal, |exponent| is 0 or from
/// 1e-200 to 1e200, and the result is normal.
[[nodiscard]] double ScaledPow(double scale, DoubleDouble base, DoubleDouble exponent);

/// (e^x - e^-x) / 2; error below 0.55 ulp.
[[nodiscard]] double Sinh(double x);

/// The inverse of Sinh, log(x + sqrt(x^2 + 1)); error below 0.55 ulp.
[[nodiscard]] double Asinh(double x);

/// The cube root; error below 0.51 ulp, and none at cubes.
[[nodiscard]] double Cbrt(double x);

/// 2 / sqrt(pi) times the integral of e^(-t^2) from x to infinity; error below 0.8 ulp.
[[nodiscard]] double Erfc(double x);

}  // namespace haptometer
