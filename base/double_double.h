#pragma once

#include <bit>
#include <cstdint>

namespace haptometer {

/// high + low, a number of about 106 bits; |low| is a small part of |high|.
///
/// The functions below round each sum and product to double, in the order in which they stand: a
/// compiler must not contract them (-ffp-contract=off) nor reorder them.
struct DoubleDouble {
  double high = 0;
  double low = 0;
};

/// a + b without error, for |a| >= |b| or a = 0.
/// Source: T. J. Dekker, "A floating-point technique for extending the available precision",
/// Numer. Math. 18 (1971), p. 227.
[[nodiscard]] constexpr DoubleDouble SumOfOrdered(double a, double b) {
  const double sum = a + b;
  return {sum, (a - sum) + b};
}

/// a + b without error.
/// Source: D. E. Knuth, "The Art of Computer Programming 2", section 4.2.2, theorem B.
[[nodiscard]] constexpr DoubleDouble ExactSum(double a, double b) {
  const double sum = a + b;
  const double part = sum - a;
  return {sum, (a - (sum - part)) + (b - part)};
}

/// The first 26 bits of a double; the other 27 are the difference, which is exact.
[[nodiscard]] constexpr double FirstBits(double a) {
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(a) & ~std::uint64_t{0x7ffffff});
}

/// a b within 2^-106 of it, without a fused product: of halves, as Dekker's (p. 234). |a b| from
/// 2^-960 to 2^1023.
[[nodiscard]] constexpr DoubleDouble ExactProduct(double a, double b) {
  const double product = a * b;
  const double a1 = FirstBits(a), b1 = FirstBits(b);
  const double a2 = a - a1, b2 = b - b1;
  return {product, ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2};
}

/// a + b within 2^-104 of |a| + |b|.
[[nodiscard]] constexpr DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble sum = ExactSum(a.high, b.high);
  return SumOfOrdered(sum.high, sum.low + (a.low + b.low));
}

/// a b within 2^-103 of it.
[[nodiscard]] constexpr DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble product = ExactProduct(a.high, b.high);
  return SumOfOrdered(product.high, product.low + (a.high * b.low + a.low * b.high));
}

/// a / b within 2^-101 of it.
[[nodiscard]] constexpr DoubleDouble operator/(DoubleDouble a, DoubleDouble b) {
  const double quotient = a.high / b.high;
  const DoubleDouble product = ExactProduct(quotient, b.high);
  const double rest = ((a.high - product.high) - product.low) + (a.low - quotient * b.low);
  return SumOfOrdered(quotient, rest / b.high);
}

/// 2^exponent, from 2^-1022 to 2^1023.
[[nodiscard]] constexpr double PowerOfTwo(int exponent) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52);
}

/// (high + low) 2^exponent with one rounding, also where the result is subnormal; |high| from
/// 2^-20 to 4.
[[nodiscard]] double Scaled(DoubleDouble a, int exponent);

/// mantissa 2^exponent, the mantissa from 1 to 2 with the sign, of a finite number that is not 0.
struct Parts {
  double mantissa = 0;
  int exponent = 0;
};
[[nodiscard]] constexpr Parts PartsOf(double a) {
  constexpr std::uint64_t kExponentBits = 0x7ff0000000000000;
  // a subnormal is first made a normal number
  const bool is_subnormal = (std::bit_cast<std::uint64_t>(a) & kExponentBits) == 0;
  const auto bits = std::bit_cast<std::uint64_t>(is_subnormal ? a * 0x1p54 : a);
  const int exponent = static_cast<int>((bits & kExponentBits) >> 52) - (is_subnormal ? 54 : 0);
  return {std::bit_cast<double>((bits & ~kExponentBits) | 0x3ff0000000000000), exponent - 1023};
}

}  // namespace haptometer
