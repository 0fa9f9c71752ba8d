#include "base/elementary_functions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "base/circular_functions.h"
#include "base/elementary_tables.h"

namespace haptometer {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kLargest = std::numeric_limits<double>::max();
constexpr double kLeast = std::numeric_limits<double>::denorm_min();

// the same double, with the sign of 0; any NaN for NaN
#define EXPECT_SAME(VALUE, EXPECTED) \
  EXPECT_TRUE(IsSame(VALUE, EXPECTED)) << #VALUE << " = " << (VALUE) << ", not " << (EXPECTED)

bool IsSame(double value, double expected) {
  if (std::isnan(expected)) return std::isnan(value);
  return std::bit_cast<std::uint64_t>(value) == std::bit_cast<std::uint64_t>(expected);
}

// a function by its name in the reference, and the error in ulp that its header states
struct Stated {
  double (*function)(double, double);
  double bound_ulp;
};

const std::map<std::string, Stated>& Functions() {
  static const std::map<std::string, Stated> functions{
      {"Exp", {[](double x, double) { return Exp(x); }, 0.52}},
      {"Expm1", {[](double x, double) { return Expm1(x); }, 0.7}},
      {"Log", {[](double x, double) { return Log(x); }, 0.52}},
      {"Log1p", {[](double x, double) { return Log1p(x); }, 0.53}},
      {"Log10", {[](double x, double) { return Log10(x); }, 0.51}},
      {"Sinh", {[](double x, double) { return Sinh(x); }, 0.55}},
      {"Asinh", {[](double x, double) { return Asinh(x); }, 0.55}},
      {"Cbrt", {[](double x, double) { return Cbrt(x); }, 0.51}},
      {"Erfc", {[](double x, double) { return Erfc(x); }, 0.8}},
      {"Sin", {[](double x, double) { return Sin(x); }, 0.85}},
      {"Cos", {[](double x, double) { return Cos(x); }, 0.85}},
      {"Tan", {[](double x, double) { return Tan(x); }, 0.6}},
      {"Pow", {Pow, 0.65}},
      {"Hypot", {Hypot, 0.87}},
      {"Atan2", {Atan2, 0.55}},
  };
  return functions;
}

// oracle: mpmath with 160 bits (reference/elementary_reference.py); the bounds are the headers'
TEST(ElementaryFunctions, AreWithinTheirStatedErrors) {
  std::ifstream file(HAPTOMETER_FIXTURES "/../tests/base/reference/elementary_reference.csv");
  std::string line;
  std::getline(file, line);
  int rows = 0;
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    std::vector<std::string> row(6);
    for (std::string& cell : row) std::getline(cells, cell, ',');
    const auto number = [&row](std::size_t at) { return std::strtod(row[at].c_str(), nullptr); };
    const Stated& stated = Functions().at(row[0]);
    const double value = stated.function(number(1), number(2));
    // the distance from the nearest double in its last bits is exact
    const double away = std::ldexp(value - number(3), -std::atoi(row[4].c_str()));
    EXPECT_LT(std::abs(away - number(5)), stated.bound_ulp) << line << ": " << value;
    ++rows;
  }
  EXPECT_GT(rows, 1700);
}

using Real = long double;

// A polynomial of the tables, in x or in x^2. Its value times |x|^power is the part of `function`
// that it stands for; `term` gives the coefficients of the series of which it is the sum.
struct Polynomial {
  const char* name;
  std::span<const double> coefficients;
  bool is_in_square;
  int power;
  Real (*term)(int);
  Real (*function)(Real);
  double end;
  double error_log2;  // stated beside the coefficients; of exp and erf in parts of 1
};

Real Factorial(int n) { return std::tgamma(static_cast<Real>(n) + 1); }
Real Sign(int n) { return n % 2 == 0 ? 1 : -1; }
// (2 n)! / (4^n n!^2), the ratio of one to the next being (2 n - 1) / (2 n)
Real CentralShare(int n) {
  Real share = 1;
  for (int j = 1; j <= n; ++j) share *= static_cast<Real>(2 * j - 1) / static_cast<Real>(2 * j);
  return share;
}

std::vector<Polynomial> Polynomials() {
  using namespace elementary;
  return {
      {"exp", kExpTail, false, 2, [](int k) { return 1 / Factorial(k + 2); },
       [](Real) { return Real{1}; }, std::numbers::ln2 / 256, -65.3},
      {"expm1", kExpm1Tail, false, 3, [](int k) { return 1 / Factorial(k + 3); },
       [](Real x) { return std::expm1(x); }, 0.0625, -60.3},
      {"log", kLogTail, false, 3, [](int k) { return Sign(k) / static_cast<Real>(k + 3); },
       [](Real x) { return std::log1p(x); }, 0x1p-7, -72.9},
      {"sin", kSinTail, true, 3, [](int k) { return -Sign(k) / Factorial(2 * k + 3); },
       [](Real x) { return std::sin(x); }, std::numbers::pi / 4, -57.8},
      {"cos", kCosTail, true, 4, [](int k) { return Sign(k) / Factorial(2 * k + 4); },
       [](Real x) { return std::cos(x); }, std::numbers::pi / 4, -63.7},
      {"sinh", kSinhTail, true, 3, [](int k) { return 1 / Factorial(2 * k + 3); },
       [](Real x) { return std::sinh(x); }, 0.3, -64.0},
      {"asinh", kAsinhTail, true, 3,
       [](int k) { return -Sign(k) * CentralShare(k + 1) / static_cast<Real>(2 * k + 3); },
       [](Real x) { return std::asinh(x); }, 0.25, -65.3},
      {"atan", kAtanTail, true, 3, [](int k) { return -Sign(k) / static_cast<Real>(2 * k + 3); },
       [](Real x) { return std::atan(x); }, 1.0 / 63, -71.8},
      {"erf", kErfTail, true, 3,
       [](int k) {
         constexpr Real kSlope = 2 * std::numbers::inv_sqrtpi_v<Real>;
         return -Sign(k) * kSlope / (Factorial(k + 1) * static_cast<Real>(2 * k + 3));
       },
       [](Real) { return Real{1}; }, 0.5, -62.7},
  };
}

// |polynomial - series| |x|^power in parts of the function
Real ErrorOf(const Polynomial& polynomial, Real x) {
  const Real step = polynomial.is_in_square ? x * x : x;
  Real ours = 0;
  for (std::size_t k = polynomial.coefficients.size(); k-- > 0;) {
    ours = ours * step + static_cast<Real>(polynomial.coefficients[k]);
  }
  Real series = 0;
  for (int k = 40; k >= 0; --k) series = series * step + polynomial.term(k);
  return std::abs((ours - series) * std::pow(x, static_cast<Real>(polynomial.power)) /
                  polynomial.function(x));
}

// Oracle: the power series, of which 41 terms leave out less than 2^-160. The smallest coefficient
// counts: half of the last one of the logarithm is 2^-60 of the result, and 2^-72.9 are stated.
TEST(ElementaryTables, PolynomialsAreTheirSeriesWithinTheStatedErrors) {
  if (std::numeric_limits<Real>::digits < 64) GTEST_SKIP() << "long double has too few bits";
  for (const Polynomial& polynomial : Polynomials()) {
    // the statements leave out the ends of the ranges, where log and atan have up to 2^0.02 more
    const Real most = std::exp2(static_cast<Real>(polynomial.error_log2 + 0.05));
    for (int k = -32; k <= 32; ++k) {
      if (k == 0) continue;
      const Real x = static_cast<Real>(polynomial.end) * static_cast<Real>(k) / 32;
      EXPECT_LE(ErrorOf(polynomial, x), most) << polynomial.name << " " << k << "/32";
    }
  }
  const auto& c = elementary::kCbrtStart;
  for (int k = 0; k <= 64; ++k) {
    const double m = 1 + k / 64.0;
    const double start = c[0] + m * (c[1] + m * (c[2] + m * c[3]));
    EXPECT_LE(std::abs(start / std::cbrt(m) - 1), std::exp2(-13.7)) << m;
  }
}

TEST(ElementaryFunctions, ExponentialsOfSpecialValuesAreThoseOfC99) {
  EXPECT_SAME(Exp(0.0), 1.0);
  EXPECT_SAME(Exp(-0.0), 1.0);
  EXPECT_SAME(Exp(-kInfinite), 0.0);
  EXPECT_SAME(Exp(kInfinite), kInfinite);
  EXPECT_SAME(Exp(kNan), kNan);
  EXPECT_SAME(Exp(709.782712893385), kInfinite);
  EXPECT_SAME(Exp(kLargest), kInfinite);
  EXPECT_SAME(Exp(-745.14), 0.0);
  EXPECT_SAME(Exp(-745.13), kLeast);
  EXPECT_SAME(Expm1(-0.0), -0.0);
  EXPECT_SAME(Expm1(kLeast), kLeast);
  EXPECT_SAME(Expm1(-kInfinite), -1.0);
  EXPECT_SAME(Expm1(-1e3), -1.0);
  EXPECT_SAME(Expm1(kInfinite), kInfinite);
  EXPECT_SAME(Expm1(kNan), kNan);
  EXPECT_SAME(Sinh(-0.0), -0.0);
  EXPECT_SAME(Sinh(-kInfinite), -kInfinite);
  EXPECT_SAME(Sinh(711.0), kInfinite);
  EXPECT_SAME(Sinh(kNan), kNan);
  EXPECT_SAME(Erfc(kInfinite), 0.0);
  EXPECT_SAME(Erfc(28.0), 0.0);
  EXPECT_SAME(Erfc(-kInfinite), 2.0);
  EXPECT_SAME(Erfc(-0.0), 1.0);
  EXPECT_SAME(Erfc(kNan), kNan);
}

TEST(ElementaryFunctions, LogarithmsOfSpecialValuesAreThoseOfC99) {
  for (const auto log : {Log, Log10}) {
    EXPECT_SAME(log(1), 0.0);
    EXPECT_SAME(log(0), -kInfinite);
    EXPECT_SAME(log(-0.0), -kInfinite);
    EXPECT_SAME(log(-kLeast), kNan);
    EXPECT_SAME(log(-kInfinite), kNan);
    EXPECT_SAME(log(kInfinite), kInfinite);
    EXPECT_SAME(log(kNan), kNan);
  }
  EXPECT_SAME(Log1p(-0.0), -0.0);
  EXPECT_SAME(Log1p(-1), -kInfinite);
  EXPECT_SAME(Log1p(-1.5), kNan);
  EXPECT_SAME(Log1p(kInfinite), kInfinite);
  EXPECT_SAME(Log1p(kNan), kNan);
  EXPECT_SAME(Asinh(-0.0), -0.0);
  EXPECT_SAME(Asinh(-kInfinite), -kInfinite);
  EXPECT_SAME(Asinh(kNan), kNan);
}

// all of Annex F.9.4.4
TEST(ElementaryFunctions, PowersOfSpecialValuesAreThoseOfC99) {
  for (const double x : {0.0, -0.0}) {
    EXPECT_SAME(Pow(x, -3), std::copysign(kInfinite, x));
    EXPECT_SAME(Pow(x, 3), x);
    for (const double y : {2.0, 0.5, kInfinite, 1e300}) {
      EXPECT_SAME(Pow(x, y), 0.0);
      EXPECT_SAME(Pow(x, -y), kInfinite);
    }
  }
  for (const double y : {0.0, -0.0, 3.0, kInfinite, -kInfinite, kNan}) EXPECT_SAME(Pow(1, y), 1.0);
  for (const double x : {0.0, -2.5, kInfinite, -kInfinite, kNan}) {
    EXPECT_SAME(Pow(x, 0.0), 1.0);
    EXPECT_SAME(Pow(x, -0.0), 1.0);
  }
  EXPECT_SAME(Pow(-1, kInfinite), 1.0);
  EXPECT_SAME(Pow(-1, -kInfinite), 1.0);
  EXPECT_SAME(Pow(-2, 0.5), kNan);
  EXPECT_SAME(Pow(2, kNan), kNan);
  EXPECT_SAME(Pow(kNan, 2), kNan);
  for (const double small : {0.5, -0.5}) {
    EXPECT_SAME(Pow(small, -kInfinite), kInfinite);
    EXPECT_SAME(Pow(small, kInfinite), 0.0);
    EXPECT_SAME(Pow(1 / small, -kInfinite), 0.0);
    EXPECT_SAME(Pow(1 / small, kInfinite), kInfinite);
  }
  EXPECT_SAME(Pow(kInfinite, 0.5), kInfinite);
  EXPECT_SAME(Pow(kInfinite, -0.5), 0.0);
  EXPECT_SAME(Pow(-kInfinite, -3), -0.0);
  EXPECT_SAME(Pow(-kInfinite, -2), 0.0);
  EXPECT_SAME(Pow(-kInfinite, 3), -kInfinite);
  EXPECT_SAME(Pow(-kInfinite, 2.5), kInfinite);
}

TEST(ElementaryFunctions, PowersOverflowAndUnderflowWithTheirSign) {
  EXPECT_SAME(Pow(10, 309), kInfinite);
  EXPECT_SAME(Pow(-10, 309), -kInfinite);
  EXPECT_SAME(Pow(10, -330), 0.0);
  EXPECT_SAME(Pow(-10, -331), -0.0);
  EXPECT_SAME(Pow(std::nextafter(1, 2), 1e300), kInfinite);
  EXPECT_SAME(Pow(std::nextafter(1, 0), 1e300), 0.0);
  EXPECT_SAME(Pow(2, 1e-30), 1.0);
}

TEST(ElementaryFunctions, AnglesOfSpecialValuesAreThoseOfC99) {
  for (const auto function : {Sin, Cos, Tan}) {
    EXPECT_SAME(function(kInfinite), kNan);
    EXPECT_SAME(function(-kInfinite), kNan);
    EXPECT_SAME(function(kNan), kNan);
  }
  for (const double x : {0.0, -0.0, kLeast, -kLeast}) {
    EXPECT_SAME(Sin(x), x);
    EXPECT_SAME(Tan(x), x);
    EXPECT_SAME(Cos(x), 1.0);
  }
  constexpr double kPi = std::numbers::pi;
  for (const double sign : {1.0, -1.0}) {
    EXPECT_SAME(Atan2(sign * 0.0, -0.0), sign * kPi);
    EXPECT_SAME(Atan2(sign * 0.0, 0.0), sign * 0.0);
    EXPECT_SAME(Atan2(sign * 0.0, -3), sign * kPi);
    EXPECT_SAME(Atan2(sign * 0.0, 3), sign * 0.0);
    EXPECT_SAME(Atan2(sign * 2, 0.0), sign * kPi / 2);
    EXPECT_SAME(Atan2(sign * 2, -0.0), sign * kPi / 2);
    EXPECT_SAME(Atan2(sign * 2, -kInfinite), sign * kPi);
    EXPECT_SAME(Atan2(sign * 2, kInfinite), sign * 0.0);
    EXPECT_SAME(Atan2(sign * kInfinite, -2), sign * kPi / 2);
    EXPECT_SAME(Atan2(sign * kInfinite, -kInfinite), sign * 3 * kPi / 4);
    EXPECT_SAME(Atan2(sign * kInfinite, kInfinite), sign * kPi / 4);
  }
  EXPECT_SAME(Atan2(kNan, 1), kNan);
  EXPECT_SAME(Atan2(1, kNan), kNan);
}

TEST(ElementaryFunctions, RootsOfSpecialValuesAreThoseOfC99) {
  for (const double x : {0.0, -0.0, kInfinite, -kInfinite, kNan}) EXPECT_SAME(Cbrt(x), x);
  EXPECT_SAME(Hypot(kInfinite, kNan), kInfinite);
  EXPECT_SAME(Hypot(kNan, -kInfinite), kInfinite);
  EXPECT_SAME(Hypot(kNan, 1), kNan);
  EXPECT_SAME(Hypot(0, kNan), kNan);
  EXPECT_SAME(Hypot(1e300, kNan), kNan);
  EXPECT_SAME(Hypot(kLeast, kNan), kNan);
  EXPECT_SAME(Hypot(-0.0, -0.0), 0.0);
  EXPECT_SAME(Hypot(-kLeast, 0), kLeast);
  EXPECT_SAME(Hypot(kLargest, kLargest), kInfinite);
}

#define EXPECT_ROOT(REAL, IMAGINARY, ROOT_REAL, ROOT_IMAGINARY)                    \
  EXPECT_SAME(Sqrt(std::complex<double>(REAL, IMAGINARY)).real(), ROOT_REAL);      \
  EXPECT_SAME(Sqrt(std::complex<double>(REAL, IMAGINARY)).imag(), ROOT_IMAGINARY); \
  EXPECT_SAME(Sqrt(std::complex<double>(REAL, -(IMAGINARY))).real(), ROOT_REAL);   \
  EXPECT_SAME(Sqrt(std::complex<double>(REAL, -(IMAGINARY))).imag(), -(ROOT_IMAGINARY))

// Annex G.6.4.2
TEST(ElementaryFunctions, ComplexRootsOfSpecialValuesAreThoseOfC99) {
  EXPECT_ROOT(0.0, 0.0, 0.0, 0.0);
  EXPECT_ROOT(-0.0, 0.0, 0.0, 0.0);
  EXPECT_ROOT(1.0, kInfinite, kInfinite, kInfinite);
  EXPECT_ROOT(kNan, kInfinite, kInfinite, kInfinite);
  EXPECT_ROOT(-kInfinite, 2.0, 0.0, kInfinite);
  EXPECT_ROOT(kInfinite, 2.0, kInfinite, 0.0);
  EXPECT_ROOT(kInfinite, kNan, kInfinite, kNan);
  EXPECT_ROOT(-kInfinite, kNan, kNan, kInfinite);
  EXPECT_ROOT(kNan, kNan, kNan, kNan);
  EXPECT_ROOT(2.0, kNan, kNan, kNan);
  // exact roots; the sign of 0
  EXPECT_ROOT(-4.0, 0.0, 0.0, 2.0);
  EXPECT_ROOT(9.0, 0.0, 3.0, 0.0);
  EXPECT_ROOT(3.0, 4.0, 2.0, 1.0);
  EXPECT_ROOT(-3.0, 4.0, 1.0, 2.0);
  EXPECT_ROOT(0x1.8p999, 0x1p1000, 0x1p500, 0x1p499);
  // a part that is 0 is no smallest number
  EXPECT_ROOT(0.0, 8.0, 2.0, 2.0);
  EXPECT_ROOT(-0.0, 8.0, 2.0, 2.0);
  EXPECT_ROOT(0.0, 0x1p-1073, 0x1p-537, 0x1p-537);
  EXPECT_ROOT(0.0, 0x1p1023, 0x1p511, 0x1p511);
  EXPECT_ROOT(0x1p-1074, 0.0, 0x1p-537, 0.0);
  EXPECT_ROOT(-0x1p-1074, 0.0, 0.0, 0x1p-537);
}

TEST(ElementaryFunctions, ResultsThatAreDoublesAreExact) {
  for (int k = -1074; k < 1024; ++k) EXPECT_SAME(Pow(2, k), std::ldexp(1.0, k));
  for (int k = 0; k <= 33; ++k) {
    double power = 1;
    for (int j = 0; j < k; ++j) power *= 3;
    EXPECT_SAME(Pow(3, k), power);
    EXPECT_SAME(Pow(-3, k), k % 2 == 0 ? power : -power);
    if (k <= 16) {
      EXPECT_SAME(Pow(power * power, 0.5), power);
    }
  }
  double ten = 1;
  for (int k = 0; k <= 22; ++k, ten *= 10) {
    EXPECT_SAME(Pow(10, k), ten);
    EXPECT_SAME(Log10(ten), static_cast<double>(k));
  }
  for (int k = 1; k < 200000; k += 7) {
    const double root = k;
    EXPECT_SAME(Cbrt(root * root * root), root);
    EXPECT_SAME(Cbrt(-root * root * root / 0x1p300), -root / 0x1p100);
  }
  EXPECT_SAME(Hypot(0x3p-1000, -0x4p-1000), 0x5p-1000);
  EXPECT_SAME(Hypot(0x3p1000, 0x4p1000), 0x5p1000);
  EXPECT_SAME(Hypot(20, 99), 101.0);
}

TEST(ElementaryFunctions, OfComplexNumbersAreThoseOfTheirParts) {
  const std::complex<double> z(-3, 4);
  EXPECT_SAME(Abs(z), 5.0);
  EXPECT_SAME(Arg(z), Atan2(4, -3));
  // r (cos, sin) are products of one rounding: of a radius of 1 the sine and cosine
  std::mt19937_64 random(1);
  for (int k = 0; k < 1000; ++k) {
    const double angle_rad = std::ldexp(static_cast<double>(random() >> 11), -48 - k % 40);
    const std::complex<double> turn = Polar(1, angle_rad);
    const SineAndCosine parts = SinCos(angle_rad);
    EXPECT_SAME(turn.real(), Cos(angle_rad));
    EXPECT_SAME(turn.imag(), Sin(angle_rad));
    EXPECT_SAME(parts.cosine, Cos(angle_rad));
    EXPECT_SAME(parts.sine, Sin(angle_rad));
    EXPECT_SAME(Polar(-0x1p900, angle_rad).imag(), -0x1p900 * parts.sine);
  }
  EXPECT_SAME(Polar(0, 2).real(), -0.0);
  EXPECT_SAME(Polar(2, -0.0).imag(), -0.0);
  EXPECT_SAME(Polar(kInfinite, 1).imag(), kInfinite);
}

// oracle: decimal numbers, of which a logarithmic range of decades consists
TEST(ElementaryFunctions, ScaledPowRoundsOnlyTheEnd) {
  for (const double begin : {1.0, 3.0, 0.7}) {
    const DoubleDouble ratio = DoubleDouble{begin * 1e12, 0} / DoubleDouble{begin, 0};
    for (int k = 0; k <= 12; ++k) {
      const DoubleDouble way = DoubleDouble{static_cast<double>(k), 0} / DoubleDouble{12, 0};
      EXPECT_NEAR(ScaledPow(begin, ratio, way) / (begin * Pow(10, k)), 1, 2.3e-16);
    }
  }
  const DoubleDouble thousand{1000, 0}, third = DoubleDouble{1, 0} / DoubleDouble{3, 0};
  EXPECT_SAME(ScaledPow(3000, thousand, third), 30000.0);
  EXPECT_SAME(ScaledPow(3000, thousand, {0, 0}), 3000.0);
  // e^(+-745.9) and beyond
  EXPECT_SAME(ScaledPow(1, thousand, {-107, 0}), Pow(10, -321));
  EXPECT_SAME(ScaledPow(1, thousand, {-109, 0}), 0.0);
  EXPECT_SAME(ScaledPow(1, thousand, {109, 0}), std::numeric_limits<double>::infinity());
}

// of a function's results, in order
class Hash {
 public:
  void Add(double value) {
    // which NaN is not fixed
    const auto bits = std::isnan(value) ? 1 : std::bit_cast<std::uint64_t>(value);
    hash_ = (hash_ ^ bits) * 0x100000001b3;
    hash_ ^= hash_ >> 29;
  }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325;
};

// any double, and doubles of the usual range
std::vector<double> ArgumentsOfHash() {
  std::mt19937_64 random(20130613);
  std::vector<double> values;
  for (int k = 0; k < 20000; ++k) {
    values.push_back(std::bit_cast<double>(random()));
    values.push_back(static_cast<double>(static_cast<std::int64_t>(random())) * 0x1p-60);
    values.push_back(static_cast<double>(random() >> 11) * 0x1p-52);
    values.push_back(static_cast<double>(static_cast<std::int64_t>(random())) * 0x1p-54);
  }
  return values;
}

std::uint64_t HashOf(double (*function)(double, double), const std::vector<double>& arguments) {
  Hash hash;
  for (std::size_t k = 1; k < arguments.size(); ++k)
    hash.Add(function(arguments[k], arguments[k - 1]));
  return hash.value();
}

// Recorded with g++ -O2 on a processor with fused products; -O0, -O3, clang++, and processors and C
// libraries without them gave the same.
TEST(ElementaryFunctions, GiveTheSameBytesEverywhere) {
  const std::map<std::string, std::uint64_t> recorded{
      {"Exp", 0x29f062d8da3a3f02},   {"Expm1", 0x2e8eddc2b36d4540}, {"Log", 0x52fc91c7ec3b44c4},
      {"Log1p", 0x907db12e9dbb46d7}, {"Log10", 0xde3424ac27f30880}, {"Sinh", 0x1b28dac58fdeea63},
      {"Asinh", 0x1fb27430dba2f4bb}, {"Cbrt", 0xd1a90216034958a5},  {"Erfc", 0xdb61e84977c95927},
      {"Sin", 0x2a5185ba56ed0088},   {"Cos", 0x46e6e8e63ab0f3dc},   {"Tan", 0x198dafef3cf56048},
      {"Pow", 0x81c3faf20fd2d3c5},   {"Hypot", 0xef97792f0227c881}, {"Atan2", 0x4a00f3bc411b2676},
  };
  const std::vector<double> arguments = ArgumentsOfHash();
  for (const auto& [name, stated] : Functions()) {
    EXPECT_EQ(HashOf(stated.function, arguments), recorded.at(name)) << name;
  }
  const auto root = [](double x, double y) {
    const std::complex<double> z = Sqrt(std::complex<double>(x, y));
    return z.real() - 3 * z.imag();
  };
  const auto polar = [](double x, double y) {
    const std::complex<double> z = Polar(x, y);
    return z.real() - 3 * z.imag();
  };
  EXPECT_EQ(HashOf(root, arguments), 0x05d0b1af6c9fc67f);
  EXPECT_EQ(HashOf(polar, arguments), 0xf2ab7a02ed8bdf91);
}

}  // namespace
}  // namespace haptometer
