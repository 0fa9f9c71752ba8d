#include "base/circular_functions.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/double_double.h"
#include "base/elementary_tables.h"

namespace haptometer {

namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kEndless = std::numeric_limits<double>::infinity();
constexpr DoubleDouble kHalfPi{elementary::kHalfPiHigh, elementary::kHalfPiLow};

// an angle is quadrant pi/2 + high + low, |high| <= pi/4
struct Reduced {
  double high;
  double low;
  std::uint64_t quadrant;  // its last two bits
};

// The fraction of |angle| / (pi/2) beyond its quadrant, as limbs of 32 bits, the first at 2^-32.
struct Turn {
  std::array<std::uint32_t, 6> fraction;
  std::uint64_t quadrant;
};

// |angle| from 2^-30 on, finite
Turn TurnOf(double angle_rad) {
  // |angle| = whole 2^exponent; limbs ahead of `begin` give multiples of 4
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(angle_rad);
  const std::uint64_t whole = (bits & 0xfffffffffffff) | 0x10000000000000;
  const int exponent = static_cast<int>(bits >> 52 & 0x7ff) - 1075;
  const int begin = std::max(0, (exponent - 2) / 32);
  // whole times 7 limbs, the last limb first
  std::array<std::uint32_t, 9> product{};
  const std::uint64_t low = whole & 0xffffffff, high = whole >> 32;
  std::uint64_t carry = 0, above = 0;
  for (std::size_t k = 0; k < 9; ++k) {
    const std::uint64_t limb =
        k < 7 ? elementary::kBitsOfPerHalfPi[static_cast<std::size_t>(begin) + 6 - k] : 0;
    const std::uint64_t sum = limb * low + (above & 0xffffffff) + carry;
    above = limb * high + (above >> 32);
    product[k] = static_cast<std::uint32_t>(sum);
    carry = sum >> 32;
  }
  // 1 stands at this bit of the product
  const int one = 7 * 32 + 32 * begin - exponent;
  const auto bits_at = [&product](int at) {
    // the product ends with bit 0: of the last limb of the fraction one bit may lie below
    if (at < 0) return product[0] << -at;
    const auto limb = static_cast<std::size_t>(at / 32);
    const std::uint64_t two =
        product[limb] | (limb + 1 < 9 ? std::uint64_t{product[limb + 1]} << 32 : 0);
    return static_cast<std::uint32_t>(two >> (at % 32));
  };
  Turn turn{};
  turn.quadrant = bits_at(one);
  for (int k = 0; k < 6; ++k)
    turn.fraction[static_cast<std::size_t>(k)] = bits_at(one - 32 * (k + 1));
  return turn;
}

// by Payne and Hanek
Reduced ReducedByBits(double angle_rad) {
  Turn turn = TurnOf(angle_rad);
  // to the nearest quadrant: a fraction above 1/2 becomes negative
  const bool is_above = turn.fraction[0] >> 31 != 0;
  if (is_above) {
    for (std::uint32_t& limb : turn.fraction) limb = ~limb;
    ++turn.quadrant;
  }
  DoubleDouble fraction;
  for (std::size_t k = turn.fraction.size(); k-- > 0;) {
    const double part = turn.fraction[k] * PowerOfTwo(-32 * static_cast<int>(k + 1));
    const DoubleDouble sum = ExactSum(part, fraction.high);
    fraction = SumOfOrdered(sum.high, sum.low + fraction.low);
  }
  const DoubleDouble rest = fraction * kHalfPi;
  const bool is_negative = std::signbit(angle_rad);
  const double sign = is_negative == is_above ? 1 : -1;
  return {sign * rest.high, sign * rest.low, is_negative ? 0 - turn.quadrant : turn.quadrant};
}

// |angle| < 2^23; by Cody and Waite
[[gnu::always_inline]] inline Reduced ReducedByParts(double angle_rad) {
  constexpr double kWholeShift = 0x1.8p52;  // the sum with it is a whole number
  const double shifted = angle_rad * elementary::kPerHalfPi + kWholeShift;
  const double quarters = shifted - kWholeShift;
  // no rounding in the first two products, nor in the first difference
  const DoubleDouble difference = ExactSum(angle_rad - quarters * elementary::kHalfPiFirst,
                                           -quarters * elementary::kHalfPiSecond);
  const double third = quarters * elementary::kHalfPiThird;
  const double high = difference.high - third;
  // next to a multiple of pi/2 the three parts have too few bits
  if (std::abs(high) < 0x1p-30 && quarters != 0) return ReducedByBits(angle_rad);
  return {high, ((difference.high - high) - third) + difference.low,
          std::bit_cast<std::uint64_t>(shifted)};
}

// sums whose rounding gives the sine and the cosine of high + low
struct Unrounded {
  DoubleDouble sine;
  DoubleDouble cosine;
};

[[gnu::always_inline]] inline Unrounded UnroundedOf(const Reduced& angle) {
  const auto& s = elementary::kSinTail;
  const auto& c = elementary::kCosTail;
  const double r = angle.high, square = r * r, fourth = square * square, half = 0.5 * square;
  const double sine = ((s[0] + square * s[1]) + fourth * (s[2] + square * s[3])) +
                      fourth * fourth * (s[4] + square * s[5]);
  const double cosine = ((c[0] + square * c[1]) + fourth * (c[2] + square * c[3])) +
                        fourth * fourth * (c[4] + square * c[5]);
  const double line = 1 - half;
  return {{r, r * (square * sine) + (angle.low - half * angle.low)},
          {line, ((1 - line) - half) + (fourth * cosine - r * angle.low)}};
}

double Rounded(const DoubleDouble& sum, bool is_negative) {
  const double value = sum.high + sum.low;
  return is_negative ? -value : value;
}

enum class Size : std::uint8_t { kUsual, kTiny, kLarge, kNotFinite };

// angles from 2^-27 to 2^23 are usual
Size SizeOf(double angle_rad) {
  const std::uint64_t exponent = std::bit_cast<std::uint64_t>(angle_rad) >> 52 & 0x7ff;
  if (exponent - (1023 - 27) < 50) return Size::kUsual;
  if (exponent < 1023) return Size::kTiny;
  return exponent == 0x7ff ? Size::kNotFinite : Size::kLarge;
}

[[gnu::always_inline]] inline Reduced ReducedOf(double angle_rad) {
  switch (SizeOf(angle_rad)) {
    case Size::kUsual:
      return ReducedByParts(angle_rad);
    case Size::kTiny:
      return {angle_rad, 0, 0};
    case Size::kLarge:
      return ReducedByBits(angle_rad);
    case Size::kNotFinite:
      break;
  }
  return {kNotANumber, 0, 0};
}

double SineOf(double angle_rad, const Reduced& reduced, const Unrounded& parts) {
  if (std::abs(angle_rad) < 0x1p-27) return angle_rad;  // the sign of 0 too
  return Rounded(reduced.quadrant % 2 == 0 ? parts.sine : parts.cosine,
                 (reduced.quadrant & 2) != 0);
}

double CosineOf(const Reduced& reduced, const Unrounded& parts) {
  return Rounded(reduced.quadrant % 2 == 0 ? parts.cosine : parts.sine,
                 ((reduced.quadrant + 1) & 2) != 0);
}

}  // namespace

double Sin(double angle_rad) {
  const Reduced reduced = ReducedOf(angle_rad);
  return SineOf(angle_rad, reduced, UnroundedOf(reduced));
}

double Cos(double angle_rad) {
  const Reduced reduced = ReducedOf(angle_rad);
  return CosineOf(reduced, UnroundedOf(reduced));
}

SineAndCosine SinCos(double angle_rad) {
  const Reduced reduced = ReducedOf(angle_rad);
  const Unrounded parts = UnroundedOf(reduced);
  return {SineOf(angle_rad, reduced, parts), CosineOf(reduced, parts)};
}

double Tan(double angle_rad) {
  if (std::abs(angle_rad) < 0x1p-27) return angle_rad;  // the sign of 0 too
  const Reduced reduced = ReducedOf(angle_rad);
  if (std::isnan(reduced.high)) return reduced.high;
  // as UnroundedOf, with more bits of the square
  const auto& s = elementary::kSinTail;
  const auto& c = elementary::kCosTail;
  const double r = reduced.high;
  const DoubleDouble square = ExactProduct(r, r);
  const double z = square.high, fourth = z * z;
  const double sine_tail = (s[1] + z * s[2]) + fourth * ((s[3] + z * s[4]) + fourth * s[5]);
  const double cosine_tail =
      ((c[0] + z * c[1]) + fourth * (c[2] + z * c[3])) + fourth * fourth * (c[4] + z * c[5]);
  const DoubleDouble cube = square * DoubleDouble{r, 0};
  const DoubleDouble cubic = cube * DoubleDouble{s[0], 0};
  const DoubleDouble sine = DoubleDouble{r, reduced.low - 0.5 * z * reduced.low} +
                            (cubic + DoubleDouble{cube.high * (z * sine_tail), 0});
  const DoubleDouble cosine =
      DoubleDouble{1, 0} + (DoubleDouble{-0.5 * square.high, -0.5 * square.low - r * reduced.low} +
                            DoubleDouble{fourth * cosine_tail, 0});
  if (reduced.quadrant % 2 == 0) return (sine / cosine).high;
  return -(cosine / sine).high;
}

namespace {

// y/x of the first octant as an angle, 2^-60 <= y/x <= 1, 1 <= x < 2
DoubleDouble AngleOfOctant(double y, double x) {
  // next to the angle of k/32, tan(a - b) = (y - x k/32) / (x + y k/32)
  const double above = y / x * 32 + 0.5;
  const int k = static_cast<int>(above);  // cut off: the nearest
  const double slope = k / 32.0;
  const DoubleDouble down = ExactProduct(slope, x), over = ExactProduct(slope, y);
  const DoubleDouble tangent =
      (DoubleDouble{y, 0} + DoubleDouble{-down.high, -down.low}) / (DoubleDouble{x, 0} + over);
  const auto& c = elementary::kAtanTail;
  const double t = tangent.high, square = t * t;
  const double tail =
      t * square * ((c[0] + square * c[1]) + square * square * (c[2] + square * c[3]));
  const elementary::AtanRow& row = elementary::kAtanTable[static_cast<std::size_t>(k)];
  return DoubleDouble{row.high, row.low} + (tangent + DoubleDouble{tail, 0});
}

// (y, x) of the first quadrant, neither 0, both finite
double AngleOfQuadrant(double y, double x, bool is_left) {
  const Parts across = PartsOf(x), up = PartsOf(y);
  const int steeper = up.exponent - across.exponent;
  if (steeper < -60 && !is_left) return y / x;
  // pi - angle, pi/2 - angle, pi/2 + angle: angles below 2^-59 do not count
  const bool is_steep = y > x;
  const Parts& small = is_steep ? across : up;
  const Parts& large = is_steep ? up : across;
  const int fall = std::max(small.exponent - large.exponent, -60);
  DoubleDouble angle = AngleOfOctant(small.mantissa * PowerOfTwo(fall), large.mantissa);
  if (is_steep != is_left) angle = {-angle.high, -angle.low};
  if (is_steep) return (kHalfPi + angle).high;
  if (!is_left) return angle.high;
  return (DoubleDouble{2 * kHalfPi.high, 2 * kHalfPi.low} + angle).high;
}

}  // namespace

double Atan2(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return kNotANumber;
  const double up = std::abs(y);
  const bool is_left = std::signbit(x);
  double angle = 0;
  if (up == 0 || (std::isinf(x) && !std::isinf(y))) {
    angle = is_left ? 2 * kHalfPi.high : 0;
  } else if (x == 0 || (std::isinf(y) && !std::isinf(x))) {
    angle = kHalfPi.high;
  } else if (std::isinf(x)) {
    angle = AngleOfQuadrant(1, 1, is_left);
  } else {
    angle = AngleOfQuadrant(up, std::abs(x), is_left);
  }
  return std::copysign(angle, y);
}

namespace {

// x^2 + y^2
DoubleDouble SquareSum(double x, double y) { return ExactProduct(x, x) + ExactProduct(y, y); }

// the root of a positive number
DoubleDouble Root(DoubleDouble a) {
  const double root = std::sqrt(a.high);
  const DoubleDouble square = ExactProduct(root, root);
  return SumOfOrdered(root, (((a.high - square.high) - square.low) + a.low) / (2 * root));
}

}  // namespace

double Hypot(double x, double y) {
  if (std::isinf(x) || std::isinf(y)) return kEndless;
  const double larger = std::max(std::abs(x), std::abs(y));
  if (larger > 0x1p-400 && larger < 0x1p500) return std::sqrt(SquareSum(x, y).high);
  if (x == 0 || y == 0 || std::isnan(x) || std::isnan(y)) return std::abs(x) + std::abs(y);
  const double scale = larger < 1 ? 0x1p600 : 0x1p-600;
  return std::sqrt(SquareSum(x * scale, y * scale).high) / scale;
}

double Abs(const std::complex<double>& z) { return Hypot(z.real(), z.imag()); }

double Arg(const std::complex<double>& z) { return Atan2(z.imag(), z.real()); }

namespace {

// the product of a mantissa with 2^exponent and a sine or cosine, rounded once
double Projection(const Parts& radius, const DoubleDouble& part) {
  if (part.high == 0) return radius.mantissa * part.high;
  const DoubleDouble factor = SumOfOrdered(part.high, part.low);
  const Parts mantissa = PartsOf(factor.high);
  const DoubleDouble scaled{mantissa.mantissa, factor.low / factor.high * mantissa.mantissa};
  return Scaled(DoubleDouble{radius.mantissa, 0} * scaled, radius.exponent + mantissa.exponent);
}

}  // namespace

std::complex<double> Polar(double radius, double angle_rad) {
  if (radius == 0 || !std::isfinite(radius) || !std::isfinite(angle_rad)) {
    const SineAndCosine parts = SinCos(angle_rad);
    return {radius * parts.cosine, radius * parts.sine};
  }
  const Reduced reduced = ReducedOf(angle_rad);
  Unrounded parts = UnroundedOf(reduced);
  if (std::abs(angle_rad) < 0x1p-27) parts.sine = {angle_rad, 0};
  if (reduced.quadrant % 2 != 0) std::swap(parts.sine, parts.cosine);
  const Parts size = PartsOf(radius);
  const double x = Projection(size, parts.cosine), y = Projection(size, parts.sine);
  return {((reduced.quadrant + 1) & 2) != 0 ? -x : x, (reduced.quadrant & 2) != 0 ? -y : y};
}

namespace {

// sqrt((|x| + |z|) / 2), the larger part of the root; a number from 1/2 to 4 times 2^exponent
struct ScaledRoot {
  DoubleDouble root;
  int exponent;
};

ScaledRoot LargerPart(double x, double y) {
  const Parts across = PartsOf(x), up = PartsOf(y);
  const int largest = std::max(x == 0 ? -2000 : across.exponent, y == 0 ? -2000 : up.exponent);
  const int half = (largest + 2000) / 2 - 1000;
  // what is smaller than the other by 2^-300 does not count
  const auto scaled = [half](const Parts& part) {
    return part.exponent - 2 * half < -300
               ? 0
               : std::abs(part.mantissa) * PowerOfTwo(part.exponent - 2 * half);
  };
  const double a = x == 0 ? 0 : scaled(across), b = y == 0 ? 0 : scaled(up);
  const DoubleDouble sum = DoubleDouble{a, 0} + Root(SquareSum(a, b));
  return {Root({sum.high / 2, sum.low / 2}), half};
}

// of infinite parts, and of NaN
std::complex<double> SqrtAtTheEnds(double x, double y) {
  if (std::isinf(y)) return {kEndless, y};
  if (std::isnan(x)) return {x, x};
  if (std::isnan(y) && !std::isinf(x)) return {y, y};
  if (x > 0) return {x, std::isnan(y) ? y : std::copysign(0.0, y)};
  return {std::isnan(y) ? y : 0.0, std::copysign(kEndless, y)};
}

}  // namespace

std::complex<double> Sqrt(const std::complex<double>& z) {
  const double x = z.real(), y = z.imag();
  if (!std::isfinite(x) || !std::isfinite(y)) return SqrtAtTheEnds(x, y);
  if (x == 0 && y == 0) return {0.0, y};
  const ScaledRoot large = LargerPart(x, y);
  const double larger = Scaled(large.root, large.exponent);
  // the other part is |y| / (2 larger)
  double smaller = 0;
  if (y != 0) {
    const Parts up = PartsOf(std::abs(y));
    const DoubleDouble quotient = DoubleDouble{up.mantissa, 0} / large.root;
    smaller = Scaled(quotient, up.exponent - 1 - large.exponent);
  }
  const bool is_left = std::signbit(x);
  return {is_left ? smaller : larger, std::copysign(is_left ? larger : smaller, y)};
}

}  // namespace haptometer
