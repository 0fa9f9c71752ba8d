#include "sim/tuning/interval.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace haptometer::sim {
namespace {

// holds the result of long double, whose own rounding is 2000 times finer
bool Holds(Interval interval, long double value) {
  return static_cast<long double>(interval.lower) <= value &&
         value <= static_cast<long double>(interval.upper);
}

TEST(IntervalArithmetic, HoldsWhatFinerArithmeticGives) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> exponent(-20, 20);
  const auto number = [&] { return std::exp(exponent(random)) * (random() % 2 == 0 ? 1 : -1); };
  for (int trial = 0; trial < 20000; ++trial) {
    const double a = number(), b = number();
    const Interval x = Interval::Of(a), y = Interval::Of(b);
    const auto wide = static_cast<long double>(a), other = static_cast<long double>(b);
    ASSERT_TRUE(Holds(x + y, wide + other)) << a << ' ' << b;
    ASSERT_TRUE(Holds(x - y, wide - other)) << a << ' ' << b;
    ASSERT_TRUE(Holds(x * y, wide * other)) << a << ' ' << b;
    ASSERT_TRUE(Holds(x / y, wide / other)) << a << ' ' << b;
    ASSERT_TRUE(Holds(Square(x), wide * wide)) << a;
    ASSERT_TRUE(Holds(SquareRoot(Interval::Of(std::abs(a))), std::sqrt(std::abs(wide)))) << a;
  }
}

TEST(IntervalArithmetic, HoldsEveryPairOfItsOperands) {
  const Interval a{-1, 2}, b{3, 5};
  for (const long double x : {-1.0L, 0.0L, 0.7L, 2.0L}) {
    for (const long double y : {3.0L, 4.4L, 5.0L}) {
      EXPECT_TRUE(Holds(a + b, x + y) && Holds(a - b, x - y));
      EXPECT_TRUE(Holds(a * b, x * y) && Holds(a / b, x / y));
    }
  }
  EXPECT_EQ(Square(a).lower, 0);
  EXPECT_NEAR(Square(a).upper, 4, 1e-14);
  EXPECT_FALSE(std::isfinite((b / a).upper));
}

TEST(IntervalArithmetic, IsNoWiderThanItMust) {
  const Interval third = Interval::Of(1) / Interval::Of(3);
  EXPECT_GT(third.width(), 0);
  EXPECT_LT(third.width(), 6 * 1.2e-16 / 3 * 2);
}

}  // namespace
}  // namespace haptometer::sim
