#include "base/elementary_functions.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/elementary_tables.h"

namespace haptometer {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint64_t kSignBit = 0x8000000000000000;
constexpr std::uint64_t kInfinityBits = 0x7ff0000000000000;
constexpr std::uint64_t kLeastNormalBits = 0x0010000000000000;
// the sum with it is a whole number, in the last bits of the sum
constexpr double kWhole = 0x1.8p52;

std::uint64_t BitsOf(double x) { return std::bit_cast<std::uint64_t>(x); }

// e^x = 2^exponent power (1 + tail), power = 2^(k/128) from 1 to 2
struct Exponential {
  double power;
  double tail;
  std::uint64_t exponent;  // its last 12 bits

  // 2^exponent from 2^-1022 to 2^1023
  double scale() const { return std::bit_cast<double>(BitsOf(power) + (exponent << 52)); }
  int whole_exponent() const {
    return static_cast<int>(static_cast<std::int64_t>(exponent << 52) >> 52);
  }
  // 2^exponent (high + low) = e^x
  DoubleDouble mantissa() const { return {power, power * tail}; }
  double Value() const {
    const int e = whole_exponent();
    return std::abs(e) < 1000 ? scale() + scale() * tail : Scaled(mantissa(), e);
  }
};

// x = k ln 2 / 128 + r, |r| <= ln 2 / 256; `low` belongs to x, |x| < 1000
[[gnu::always_inline]] inline Exponential ExponentialOf(double x, double low) {
  const double shifted = x * elementary::kExpStepsPerUnit + kWhole;
  const double steps = shifted - kWhole;
  // the first product has no error, nor the difference
  const double r = (x - steps * elementary::kExpStepHigh) - (steps * elementary::kExpStepLow - low);
  const elementary::ExpRow& row = elementary::kExpTable[BitsOf(shifted) & 127];
  const auto& c = elementary::kExpTail;
  const double square = r * r;
  const double bend = (c[0] + r * c[1]) + square * (c[2] + r * c[3]);
  return {row.power, (row.tail + r) + square * bend, BitsOf(shifted) >> 7};
}

// beyond where the result is normal
double ExpAtTheEnds(double x) {
  if (std::isnan(x)) return x;
  if (x > 710) return kInfinity;
  if (x < -746) return 0;
  return ExponentialOf(x, 0).Value();
}

// log of a number m = 2^exponent mantissa: base + r with |base| > |r| or base = 0, base + rest the
// logarithm of 2^exponent / inverse, and r = inverse mantissa - 1
struct Logarithm {
  double base;
  double rest;
  double r;
  double inverse;
  std::int64_t exponent;
};

// of positive normal bits; `shift` is added to the exponent
[[gnu::always_inline]] inline Logarithm LogarithmOf(std::uint64_t bits, int shift) {
  constexpr std::uint64_t kBegin = 0x3fe6800000000000;  // 0.703125
  const std::uint64_t place = bits - kBegin;
  const std::int64_t exponent = (static_cast<std::int64_t>(place) >> 52) + shift;
  const auto mantissa = std::bit_cast<double>(bits - (place & 0xfff0000000000000));
  const elementary::LogRow& row = elementary::kLogTable[(place >> 45) & 127];
  // two products of few bits, and a sum that has 53: no error
  const double first = FirstBits(mantissa);
  const double r = (first * row.inverse - 1) + (mantissa - first) * row.inverse;
  const auto halvings = static_cast<double>(exponent);
  return {halvings * elementary::kLn2High + row.high, halvings * elementary::kLn2Low + row.low, r,
          row.inverse, exponent};
}

// (log(1 + r) - r + r^2 / 2) / r^3
[[gnu::always_inline]] inline double LogTail(double r, double square) {
  const auto& c = elementary::kLogTail;
  return ((c[0] + r * c[1]) + square * (c[2] + r * c[3])) +
         square * square * ((c[4] + r * c[5]) + square * c[6]);
}

// the logarithm, where `rest` is that of the table and of what is missing in r
[[gnu::always_inline]] inline double Rounded(const Logarithm& log, double rest) {
  const double square = log.r * log.r;
  const DoubleDouble sum = SumOfOrdered(log.base, log.r);
  const double bend = square * (log.r * LogTail(log.r, square) - 0.5);
  return sum.high + ((sum.low + rest) + bend);
}

// within 2^-65 of the logarithm, with `rest` as in Rounded
[[gnu::always_inline]] inline DoubleDouble Extended(const Logarithm& log, double rest) {
  const double r = log.r;
  // r^2 / 2 as a square of 52 bits, and the rest
  const double first = FirstBits(r);
  const DoubleDouble line = SumOfOrdered(log.base, r);
  const DoubleDouble sum = ExactSum(line.high, -0.5 * first * first);
  const double square = r * r;
  const double cubic = square * (r * LogTail(r, square));
  const double low = ((line.low + sum.low) + (rest - 0.5 * (r - first) * (r + first))) + cubic;
  return SumOfOrdered(sum.high, low);
}

// of a double-double whose high part is positive and normal
Logarithm LogarithmOf(DoubleDouble x) { return LogarithmOf(BitsOf(x.high), 0); }
double RestOf(const Logarithm& log, DoubleDouble x) {
  // 2^-exponent in two steps: it may be subnormal
  const auto half = static_cast<int>(log.exponent / 2);
  const auto other = static_cast<int>(log.exponent) - half;
  const double low = x.low * log.inverse * PowerOfTwo(-half) * PowerOfTwo(-other);
  return log.rest + (low - log.r * low);
}

// of zeros, subnormals, negative numbers, infinities and NaN: what `log` makes of the others, the
// exponent of a subnormal apart
template <typename Value>
double LogAtTheEnds(double x, Value log) {
  if (x == 0) return -kInfinity;
  if (std::isnan(x) || x == kInfinity) return x;
  if (x < 0) return kNaN;
  return log(LogarithmOf(BitsOf(x * 0x1p52), -52));
}

bool IsPositiveNormal(double x) {
  return BitsOf(x) - kLeastNormalBits < kInfinityBits - kLeastNormalBits;
}

}  // namespace

double Exp(double x) {
  if (!(std::abs(x) < 700)) return ExpAtTheEnds(x);
  const Exponential e = ExponentialOf(x, 0);
  const double scale = e.scale();
  return scale + scale * e.tail;
}

double Expm1(double x) {
  if (!(std::abs(x) >= 0x1p-54)) return x;  // NaN too
  if (std::abs(x) <= 0.0625) {
    const auto& c = elementary::kExpm1Tail;
    const double square = x * x;
    const double tail = ((c[0] + x * c[1]) + square * (c[2] + x * c[3])) +
                        square * square * ((c[4] + x * c[5]) + square * c[6]);
    return x + square * (0.5 + x * tail);
  }
  if (x > 700) return ExpAtTheEnds(x);
  if (x < -40) return -1;
  const Exponential e = ExponentialOf(x, 0);
  const double scale = e.scale();
  const DoubleDouble difference = ExactSum(scale, -1);
  return difference.high + (difference.low + scale * e.tail);
}

double Log(double x) {
  const auto natural = [](const Logarithm& log) { return Rounded(log, log.rest); };
  if (IsPositiveNormal(x)) return natural(LogarithmOf(BitsOf(x), 0));
  return LogAtTheEnds(x, natural);
}

double Log1p(double x) {
  if (!(std::abs(x) >= 0x1p-54)) return x;  // NaN too
  if (std::abs(x) <= 0x1p-8) {
    const double square = x * x;
    return x + square * (x * LogTail(x, square) - 0.5);
  }
  if (x <= -1 || x == kInfinity) return x == -1 ? -kInfinity : x < -1 ? kNaN : x;
  const DoubleDouble sum = ExactSum(1, x);
  const Logarithm log = LogarithmOf(sum);
  return Rounded(log, RestOf(log, sum));
}

double Log10(double x) {
  const auto decadic = [](const Logarithm& log) {
    constexpr DoubleDouble kPerLn10{elementary::kPerLn10High, elementary::kPerLn10Low};
    return (Extended(log, log.rest) * kPerLn10).high;
  };
  if (IsPositiveNormal(x)) return decadic(LogarithmOf(BitsOf(x), 0));
  return LogAtTheEnds(x, decadic);
}

namespace {

enum class Parity : std::uint8_t { kFraction, kEven, kOdd };

Parity ParityOf(double y) {
  if (std::abs(y) >= 0x1p53) return Parity::kEven;
  const auto whole = static_cast<std::int64_t>(y);
  if (static_cast<double>(whole) != y) return Parity::kFraction;
  return whole % 2 == 0 ? Parity::kEven : Parity::kOdd;
}

// of x or y that are 0, infinite or NaN, |x| = 1 with an infinite y
double PowOfSpecial(double x, double y) {
  if (y == 0 || x == 1) return 1;
  if (std::isnan(x) || std::isnan(y)) return kNaN;
  if (std::isinf(y)) {
    if (x == -1) return 1;
    return (std::abs(x) > 1) == (y > 0) ? kInfinity : 0;
  }
  // x is 0 or infinite
  const double size = (x == 0) == (y > 0) ? 0 : kInfinity;
  return std::signbit(x) && ParityOf(y) == Parity::kOdd ? -size : size;
}

// x^y of a positive finite x and a finite y, neither 0
double PowOfPositive(double x, double y) {
  // the result is 1, 0 or infinite, with no product that overflows or underflows
  if (std::abs(y) < 0x1p-65 || x == 1) return 1;
  if (std::abs(y) > 0x1p65) return (x > 1) == (y > 0) ? kInfinity : 0;
  const Logarithm log = x < std::numeric_limits<double>::min()
                            ? LogarithmOf(BitsOf(x * 0x1p52), -52)
                            : LogarithmOf(BitsOf(x), 0);
  const DoubleDouble exponent = Extended(log, log.rest) * DoubleDouble{y, 0};
  if (exponent.high > 710) return kInfinity;
  if (exponent.high < -746) return 0;
  return ExponentialOf(exponent.high, exponent.low).Value();
}

bool IsZeroOrNotFinite(double x) { return (BitsOf(x) & ~kSignBit) - 1 >= kInfinityBits - 1; }

}  // namespace

double Pow(double x, double y) {
  if (IsZeroOrNotFinite(x) || IsZeroOrNotFinite(y)) return PowOfSpecial(x, y);
  if (x > 0) return PowOfPositive(x, y);
  const Parity parity = ParityOf(y);
  if (parity == Parity::kFraction) return kNaN;
  const double size = PowOfPositive(-x, y);
  return parity == Parity::kOdd ? -size : size;
}

double ScaledPow(double scale, DoubleDouble base, DoubleDouble exponent) {
  const Logarithm log = LogarithmOf(base);
  const DoubleDouble product = Extended(log, RestOf(log, base)) * exponent;
  if (!(std::abs(product.high) < 746)) return product.high > 0 ? kInfinity : 0;
  const Exponential power = ExponentialOf(product.high, product.low);
  const Parts parts = PartsOf(scale);
  const DoubleDouble mantissa = power.mantissa() * DoubleDouble{parts.mantissa, 0};
  return Scaled(mantissa, power.whole_exponent() + parts.exponent);
}

double Sinh(double x) {
  const double size = std::abs(x);
  if (!(size >= 0x1p-27)) return x;  // NaN too
  if (size <= 0.3) {
    const auto& c = elementary::kSinhTail;
    const double square = x * x;
    const double tail = (c[0] + square * c[1]) +
                        square * square * ((c[2] + square * c[3]) + square * square * c[4]);
    return x + square * (x * tail);
  }
  if (size > 711) return std::copysign(kInfinity, x);
  // e^x / 2 - e^-x / 2
  const Exponential rising = ExponentialOf(size, 0);
  if (size > 40) return std::copysign(Scaled(rising.mantissa(), rising.whole_exponent() - 1), x);
  const Exponential falling = ExponentialOf(-size, 0);
  const double up = rising.scale() / 2, down = falling.scale() / 2;
  const DoubleDouble sum = SumOfOrdered(up, -down);
  return std::copysign(sum.high + (sum.low + (up * rising.tail - down * falling.tail)), x);
}

double Asinh(double x) {
  const double size = std::abs(x);
  if (!(size >= 0x1p-27) || size == kInfinity) return x;  // NaN too
  if (size <= 0.25) {
    const auto& c = elementary::kAsinhTail;
    const double square = x * x, fourth = square * square;
    const double tail =
        ((c[0] + square * c[1]) + fourth * (c[2] + square * c[3])) +
        fourth * fourth *
            ((c[4] + square * c[5]) + fourth * ((c[6] + square * c[7]) + fourth * c[8]));
    return x + square * (x * tail);
  }
  if (size > 0x1p28) {
    const Logarithm doubled = LogarithmOf(BitsOf(size), 1);
    return std::copysign(Rounded(doubled, doubled.rest), x);
  }
  // the root of x^2 + 1, and what its square lacks
  const DoubleDouble square = DoubleDouble{1, 0} + ExactProduct(size, size);
  const double root = std::sqrt(square.high);
  const DoubleDouble back = ExactProduct(root, root);
  const double low = ((square.high - back.high) - back.low + square.low) / (2 * root);
  const DoubleDouble sum = DoubleDouble{root, low} + DoubleDouble{size, 0};
  const Logarithm log = LogarithmOf(sum);
  return std::copysign(Rounded(log, RestOf(log, sum)), x);
}

double Cbrt(double x) {
  if (x == 0 || !std::isfinite(x)) return x;
  // |x| = 2^(3 third) m, m from 1 to 8
  const Parts parts = PartsOf(std::abs(x));
  const int third = (parts.exponent + 1200) / 3 - 400;
  const int rest = parts.exponent - 3 * third;
  const double m = parts.mantissa * PowerOfTwo(rest);
  // a polynomial, then Halley's step
  const auto& c = elementary::kCbrtStart;
  const double t = parts.mantissa;
  const double start = ((c[0] + t * c[1]) + t * t * (c[2] + t * c[3])) *
                       elementary::kCbrtOfPowers[static_cast<std::size_t>(rest)];
  const double cube = start * start * start;
  // 26 bits, so that their square has no error; a last step with what their cube lacks
  const double root = FirstBits(start * (cube + 2 * m) / (2 * cube + m) * (1 + 0x1p-27));
  const DoubleDouble exact = ExactProduct(root * root, root);
  const double lacking = (m - exact.high) - exact.low;
  const double result = root + root * (lacking / (3 * exact.high + lacking));
  return std::copysign(result * PowerOfTwo(third), x);
}

namespace {

// 1 - 2 / sqrt(pi) x - ..., |x| < 1/2
double ErfcOfSmall(double x) {
  const auto& c = elementary::kErfTail;
  const double square = x * x, fourth = square * square;
  const double tail =
      ((c[0] + square * c[1]) + fourth * (c[2] + square * c[3])) +
      fourth * fourth *
          ((c[4] + square * c[5]) + fourth * ((c[6] + square * c[7]) + fourth * c[8]));
  const DoubleDouble line = ExactProduct(x, elementary::kErfSlopeHigh);
  const DoubleDouble sum = ExactSum(1, -line.high);
  return sum.high + (sum.low - (line.low + x * elementary::kErfSlopeLow + square * (x * tail)));
}

// e^(-x^2) times the table's e^(x^2) erfc(x), 1/2 <= x < 28
double ErfcOfLarge(double x) {
  // the interval's middle: half a quarter of an octave up
  const std::uint64_t place = BitsOf(x) >> 50;
  const auto middle = std::bit_cast<double>((place << 50) | (std::uint64_t{1} << 49));
  const elementary::ErfcRow& row = elementary::kErfcTable[place - (BitsOf(0.5) >> 50)];
  const auto& c = row.slopes;
  const double t = x - middle, square = t * t, fourth = square * square;
  const double slope =
      ((c[0] + t * c[1]) + square * (c[2] + t * c[3])) +
      fourth * ((c[4] + t * c[5]) + square * (c[6] + t * c[7])) +
      fourth * fourth *
          (((c[8] + t * c[9]) + square * (c[10] + t * c[11])) + fourth * (c[12] + t * c[13]));
  // x^2 loses no bits
  const DoubleDouble exponent = ExactProduct(x, x);
  const Exponential fall = ExponentialOf(-exponent.high, -exponent.low);
  const DoubleDouble factor = ExactProduct(fall.power, row.high);
  const double rest = fall.power * (row.low + t * slope);
  const double tail = fall.tail * (factor.high + rest);
  const DoubleDouble sum = SumOfOrdered(factor.high, rest);
  return Scaled({sum.high, sum.low + (factor.low + tail)}, fall.whole_exponent());
}

}  // namespace

double Erfc(double x) {
  if (std::isnan(x)) return x;
  if (std::abs(x) < 0.5) return ErfcOfSmall(x);
  if (x > 27.5) return 0;
  if (x < -6) return 2;
  return x > 0 ? ErfcOfLarge(x) : 2 - ErfcOfLarge(-x);
}

}  // namespace haptometer
