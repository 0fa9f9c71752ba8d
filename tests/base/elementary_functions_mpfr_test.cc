// Every function against MPFR, which shares no method with it, at some 400 000 arguments over the
// whole range of doubles: the stated bounds of the error hold.
#include <gtest/gtest.h>
#include <mpfr.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "base/circular_functions.h"
#include "base/elementary_functions.h"

namespace haptometer {
namespace {

constexpr int kBits = 300;
constexpr double kLargest = std::numeric_limits<double>::max();

class Number {
 public:
  explicit Number(double value = 0) {
    mpfr_init2(value_, kBits);
    mpfr_set_d(value_, value, MPFR_RNDN);
  }
  ~Number() { mpfr_clear(value_); }
  Number(const Number&) = delete;
  Number& operator=(const Number&) = delete;

  mpfr_ptr get() { return value_; }

 private:
  mpfr_t value_;
};

// |value - exact| in units of the last place of a double of the size of `exact`; 0 for the same
// infinity, NaN or zero, infinite where one of them is none
double ErrorInUlp(double value, Number& exact) {
  const double nearest = mpfr_get_d(exact.get(), MPFR_RNDN);
  if (std::isnan(nearest) && std::isnan(value)) return 0;
  if (value == nearest && (std::isinf(value) || mpfr_zero_p(exact.get()) != 0)) {
    return std::signbit(value) == std::signbit(nearest) ? 0
                                                        : std::numeric_limits<double>::infinity();
  }
  // the infinity of an overflow stands for 2^1024
  if (!std::isfinite(value))
    return std::abs(nearest) == kLargest ? 1 : std::numeric_limits<double>::infinity();
  if (std::isnan(nearest) || mpfr_zero_p(exact.get()) != 0)
    return std::numeric_limits<double>::infinity();
  const long last = std::max(static_cast<long>(mpfr_get_exp(exact.get())) - 53, -1074L);
  Number difference;
  mpfr_sub_d(difference.get(), exact.get(), value, MPFR_RNDN);
  mpfr_mul_2si(difference.get(), difference.get(), -last, MPFR_RNDN);
  return std::abs(mpfr_get_d(difference.get(), MPFR_RNDN));
}

// the largest error over the arguments, and where it is
struct Worst {
  double ulp = 0;
  double x = 0;
  double y = 0;

  void Add(double error, double at_x, double at_y = 0) {
    if (!(error > ulp)) return;
    *this = {error, at_x, at_y};
  }
  std::string text() const {
    char line[100];
    std::snprintf(line, sizeof line, "%.4f ulp at %a, %a", ulp, x, y);
    return line;
  }
};

class Arguments {
 public:
  // any double but infinities and NaN, each exponent as likely
  double Any() {
    double value = 0;
    do {
      value = std::bit_cast<double>(random_());
    } while (!std::isfinite(value));
    return value;
  }
  double Within(double lower, double upper) {
    return lower + (upper - lower) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }
  // `value` and some neighbours
  double Near(double value) {
    const auto offset = static_cast<std::int64_t>(random_() % 33) - 16;
    return std::bit_cast<double>(std::bit_cast<std::int64_t>(value) + offset);
  }
  // next to a multiple of pi/2 of any size
  double NearQuarter() {
    const double size = std::ldexp(1.0, static_cast<int>(random_() % 1023));
    return Near(std::nearbyint(Within(1, 2) * size) * (std::numbers::pi / 2));
  }
  // next to a small multiple of pi/2
  double NearSmallQuarter() {
    return Near(std::nearbyint(Within(-5e6, 5e6)) * (std::numbers::pi / 2));
  }
  double NearPower() { return Near(std::ldexp(1.0, static_cast<int>(random_() % 2100) - 1074)); }

 private:
  std::mt19937_64 random_{20130613};
};

using Ours = double (*)(double);
using Theirs = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);

struct Ranges {
  std::vector<std::pair<double, double>> dense;
  std::vector<double> near;
};

struct Kinds {
  bool any = true;
  bool quarters = false;
  int rounds = 10000;
};

void ExpectBelow(double bound, Ours ours, Theirs theirs, const Ranges& ranges,
                 const Kinds& kinds = {}) {
  Arguments arguments;
  Worst worst;
  Number x, exact;
  const auto add = [&](double value) {
    mpfr_set_d(x.get(), value, MPFR_RNDN);
    theirs(exact.get(), x.get(), MPFR_RNDN);
    worst.Add(ErrorInUlp(ours(value), exact), value);
  };
  for (int k = 0; k < kinds.rounds; ++k) {
    add(arguments.Any());
    if (kinds.any) add(arguments.NearPower());
    for (const auto& [lower, upper] : ranges.dense) add(arguments.Within(lower, upper));
    for (const double value : ranges.near) add(arguments.Near(value));
    if (kinds.quarters) {
      add(arguments.NearQuarter());
      add(arguments.NearSmallQuarter());
    }
  }
  EXPECT_LT(worst.ulp, bound) << worst.text();
  ::testing::Test::RecordProperty("worst", worst.text());
}

TEST(ElementaryFunctionsMpfr, Exp) {
  ExpectBelow(
      0.52, Exp, mpfr_exp,
      {{{-1, 1}, {-745.2, -707}, {-30, 30}, {700, 710}}, {709.782712893384, -708.3964185322641}});
}
TEST(ElementaryFunctionsMpfr, Expm1) {
  ExpectBelow(0.7, Expm1, mpfr_expm1,
              {{{-1, 1}, {-0.07, 0.07}, {0.06, 0.1}, {-0.1, -0.06}, {-40, 710}},
               {709.782712893384, 0.0625, -0.0625}});
}
TEST(ElementaryFunctionsMpfr, Log) {
  ExpectBelow(0.52, Log, mpfr_log,
              {{{0, 2}, {0.98, 1.02}, {0.999, 1.001}, {0, 1e3}}, {1, 0.5, 2, 1.40625, 0.703125}});
}
TEST(ElementaryFunctionsMpfr, Log1p) {
  ExpectBelow(0.53, Log1p, mpfr_log1p,
              {{{-1, 1}, {-0.01, 0.01}, {-0.004, 0.004}, {-1, -0.99}, {0, 1e3}},
               {0.00390625, -0.00390625}});
}
TEST(ElementaryFunctionsMpfr, Log10) {
  ExpectBelow(0.51, Log10, mpfr_log10, {{{0, 2}, {0.99, 1.01}, {0, 1e3}}, {1, 10, 1000, 1e-5}});
}
TEST(ElementaryFunctionsMpfr, Sinh) {
  ExpectBelow(0.55, Sinh, mpfr_sinh,
              {{{-1, 1}, {0.29, 0.5}, {-45, 45}, {700, 711}}, {0.3, 710.4758600739439}});
}
TEST(ElementaryFunctionsMpfr, Asinh) {
  ExpectBelow(0.55, Asinh, mpfr_asinh, {{{-1, 1}, {0.24, 0.4}, {-1e3, 1e3}}, {0.25, 0x1p28}});
}
TEST(ElementaryFunctionsMpfr, Cbrt) {
  ExpectBelow(0.51, Cbrt, mpfr_cbrt, {{{0, 1}, {1, 8}, {-1e3, 1e3}}, {1, 2, 4, 8}});
}
TEST(ElementaryFunctionsMpfr, Erfc) {
  ExpectBelow(0.8, Erfc, mpfr_erfc,
              {{{-6.5, 1}, {0.45, 0.7}, {0, 5}, {0, 28}, {26, 27.5}}, {0.5, 1, 2, 26.5433}},
              {.any = false, .rounds = 500});
}
TEST(ElementaryFunctionsMpfr, Sin) {
  ExpectBelow(0.85, Sin, mpfr_sin,
              {{{-7, 7}, {0.7, 0.8}, {-1e7, 1e7}, {8.3e6, 8.5e6}}, {std::numbers::pi}},
              {.quarters = true});
}
TEST(ElementaryFunctionsMpfr, Cos) {
  ExpectBelow(0.85, Cos, mpfr_cos,
              {{{-7, 7}, {0.7, 0.8}, {-1e7, 1e7}, {8.3e6, 8.5e6}}, {std::numbers::pi}},
              {.quarters = true});
}
TEST(ElementaryFunctionsMpfr, Tan) {
  ExpectBelow(0.6, Tan, mpfr_tan,
              {{{-7, 7}, {0.7, 0.8}, {-1e7, 1e7}, {8.3e6, 8.5e6}}, {std::numbers::pi}},
              {.quarters = true});
}

using OursOfTwo = double (*)(double, double);
using TheirsOfTwo = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_srcptr, mpfr_rnd_t);

// arguments of any size, of about the same size, and of [lower, upper]
Worst WorstOfTwo(OursOfTwo ours, TheirsOfTwo theirs, double lower, double upper) {
  Arguments arguments;
  Worst worst;
  Number first, second, exact;
  const auto add = [&](double a, double b) {
    mpfr_set_d(first.get(), a, MPFR_RNDN);
    mpfr_set_d(second.get(), b, MPFR_RNDN);
    theirs(exact.get(), first.get(), second.get(), MPFR_RNDN);
    worst.Add(ErrorInUlp(ours(a, b), exact), a, b);
  };
  for (int k = 0; k < 20000; ++k) {
    const double any = arguments.Any() / 4;
    add(any, arguments.Any());
    add(any, any * arguments.Within(-4, 4));
    add(arguments.Within(lower, upper), arguments.Within(lower, upper));
    add(arguments.Within(lower, upper), std::ldexp(arguments.Within(1, 2), -k % 60));
  }
  ::testing::Test::RecordProperty("worst", worst.text());
  return worst;
}

TEST(ElementaryFunctionsMpfr, Hypot) {
  const Worst worst = WorstOfTwo(Hypot, mpfr_hypot, -2, 2);
  EXPECT_LT(worst.ulp, 0.87) << worst.text();
}

TEST(ElementaryFunctionsMpfr, Atan2) {
  const Worst worst = WorstOfTwo(Atan2, mpfr_atan2, -2, 2);
  EXPECT_LT(worst.ulp, 0.55) << worst.text();
}

TEST(ElementaryFunctionsMpfr, Pow) {
  const Worst worst = WorstOfTwo(Pow, mpfr_pow, -20, 20);
  EXPECT_LT(worst.ulp, 0.65) << worst.text();
  // results over the whole range, for bases of any size and next to 1
  Arguments arguments;
  Worst further;
  Number first, second, exact;
  const auto add = [&](double x, double y) {
    mpfr_set_d(first.get(), x, MPFR_RNDN);
    mpfr_set_d(second.get(), y, MPFR_RNDN);
    mpfr_pow(exact.get(), first.get(), second.get(), MPFR_RNDN);
    further.Add(ErrorInUlp(Pow(x, y), exact), x, y);
  };
  for (int k = 0; k < 20000; ++k) {
    for (const double x :
         {std::abs(arguments.Any()), arguments.Within(0.7, 1.5), arguments.Within(0.98, 1.02),
          1 + std::ldexp(arguments.Within(-1, 1), -k % 53)}) {
      if (x == 1 || x == 0) continue;
      add(x, arguments.Within(-746, 710) / std::log(x));
      add(x, std::nearbyint(arguments.Within(-30, 30)));
      add(-x, std::nearbyint(arguments.Within(-30, 30)));
    }
  }
  EXPECT_LT(further.ulp, 0.65) << further.text();
}

TEST(ElementaryFunctionsMpfr, Polar) {
  Arguments arguments;
  Worst worst;
  Number angle, exact;
  const auto add = [&](double radius, double angle_rad) {
    const std::complex<double> z = Polar(radius, angle_rad);
    mpfr_set_d(angle.get(), angle_rad, MPFR_RNDN);
    mpfr_cos(exact.get(), angle.get(), MPFR_RNDN);
    mpfr_mul_d(exact.get(), exact.get(), radius, MPFR_RNDN);
    worst.Add(ErrorInUlp(z.real(), exact), radius, angle_rad);
    mpfr_sin(exact.get(), angle.get(), MPFR_RNDN);
    mpfr_mul_d(exact.get(), exact.get(), radius, MPFR_RNDN);
    worst.Add(ErrorInUlp(z.imag(), exact), radius, angle_rad);
  };
  for (int k = 0; k < 20000; ++k) {
    add(arguments.Any(), arguments.Any());
    add(arguments.Within(0, 2), arguments.Within(-7, 7));
    add(arguments.Any(), arguments.NearSmallQuarter());
    add(arguments.Any(), arguments.Within(0.6, 0.8));
  }
  EXPECT_LT(worst.ulp, 0.95) << worst.text();
}

// sqrt((|x| + hypot(x, y)) / 2) and |y| / 2 over it
TEST(ElementaryFunctionsMpfr, SqrtOfComplex) {
  Arguments arguments;
  Worst worst;
  Number x, y, larger, smaller;
  const auto add = [&](double real, double imaginary) {
    mpfr_set_d(x.get(), std::abs(real), MPFR_RNDN);
    mpfr_set_d(y.get(), std::abs(imaginary), MPFR_RNDN);
    mpfr_hypot(larger.get(), x.get(), y.get(), MPFR_RNDN);
    mpfr_add(larger.get(), larger.get(), x.get(), MPFR_RNDN);
    mpfr_div_2ui(larger.get(), larger.get(), 1, MPFR_RNDN);
    mpfr_sqrt(larger.get(), larger.get(), MPFR_RNDN);
    mpfr_div(smaller.get(), y.get(), larger.get(), MPFR_RNDN);
    mpfr_div_2ui(smaller.get(), smaller.get(), 1, MPFR_RNDN);
    const std::complex<double> root = Sqrt(std::complex<double>(real, imaginary));
    const bool is_left = std::signbit(real);
    EXPECT_EQ(std::signbit(root.imag()), std::signbit(imaginary));
    worst.Add(ErrorInUlp(root.real(), is_left ? smaller : larger), real, imaginary);
    worst.Add(ErrorInUlp(std::abs(root.imag()), is_left ? larger : smaller), real, imaginary);
  };
  for (int k = 0; k < 20000; ++k) {
    const double any = arguments.Any() / 4;
    add(any, arguments.Any());
    add(any, any * arguments.Within(-4, 4));
    add(arguments.Within(-2, 2), arguments.Within(-2, 2));
  }
  EXPECT_LT(worst.ulp, 0.55) << worst.text();
}

// scale (numerator / denominator)^(part / parts), as a logarithmic sweep has it
TEST(ElementaryFunctionsMpfr, ScaledPow) {
  Arguments arguments;
  Worst worst;
  Number base, exponent, exact;
  for (int k = 0; k < 40000; ++k) {
    const double scale =
        std::abs(arguments.Any()) < 1e300 ? arguments.Within(1e-3, 1e5) : arguments.Within(1, 2);
    const double end = scale * std::exp(arguments.Within(-60, 60));
    const double part = std::nearbyint(arguments.Within(1, 99)), parts = 100;
    mpfr_set_d(base.get(), end, MPFR_RNDN);
    mpfr_set_d(exact.get(), scale, MPFR_RNDN);
    mpfr_div(base.get(), base.get(), exact.get(), MPFR_RNDN);
    mpfr_set_d(exponent.get(), part, MPFR_RNDN);
    mpfr_set_d(exact.get(), parts, MPFR_RNDN);
    mpfr_div(exponent.get(), exponent.get(), exact.get(), MPFR_RNDN);
    mpfr_pow(exact.get(), base.get(), exponent.get(), MPFR_RNDN);
    mpfr_mul_d(exact.get(), exact.get(), scale, MPFR_RNDN);
    const DoubleDouble ratio = DoubleDouble{end, 0} / DoubleDouble{scale, 0};
    const DoubleDouble way = DoubleDouble{part, 0} / DoubleDouble{parts, 0};
    worst.Add(ErrorInUlp(ScaledPow(scale, ratio, way), exact), scale, end);
  }
  EXPECT_LT(worst.ulp, 0.52) << worst.text();
}

}  // namespace
}  // namespace haptometer
