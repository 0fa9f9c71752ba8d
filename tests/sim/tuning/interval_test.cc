#include "sim/tuning/interval.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
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

// products and sums that round to 0 are not 0: the least double stands for them
TEST(IntervalArithmetic, HoldsWhatUnderflows) {
  const Interval tiny = Interval::Of(1e-200), below = Interval::Of(-1e-200);
  for (const Interval& positive :
       {tiny * tiny, below * below, Square(tiny), tiny / Interval::Of(1e200)}) {
    EXPECT_GT(positive.upper, 0);
    EXPECT_LE(positive.lower, 0);
  }
  EXPECT_LT((tiny * below).lower, 0);
  EXPECT_GE((tiny * below).upper, 0);
  EXPECT_EQ(Square(tiny).lower, 0) << "no square is negative";
}

// |x| 2^-52 either way, the half of which rounding may have cost
TEST(IntervalArithmetic, MovesItsEndsByAUnitInTheLastPlace) {
  for (const double x : {1.0, -1.0, 1.9, 3e7, -1e-9}) {
    const Interval moved = Outward(x, x);
    EXPECT_GE(x - moved.lower, 0x1p-53 * std::abs(x)) << x;
    EXPECT_GE(moved.upper - x, 0x1p-53 * std::abs(x)) << x;
    EXPECT_LE(moved.width(), 4 * 0x1p-52 * std::abs(x)) << x;
  }
}

TEST(IntervalArithmetic, HoldsRootsAndWhatIsAboveZero) {
  const Interval root = SquareRoot({.lower = 0, .upper = 9});
  EXPECT_EQ(root.lower, 0);
  EXPECT_GE(root.upper, 3);
  EXPECT_LT(root.upper, 3 + 1e-14);
  const Interval both{-2, 3}, above{1, 3}, below{-2, -1};
  EXPECT_EQ(AboveZero(both).lower, 0);
  EXPECT_EQ(AboveZero(both).upper, 3);
  EXPECT_EQ(AboveZero(above).lower, 1);
  EXPECT_EQ(AboveZero(below).upper, 0);
  EXPECT_EQ(RiseAboveZero(both).lower, 0);
  EXPECT_EQ(RiseAboveZero(both).upper, 1);
  EXPECT_EQ(RiseAboveZero(above).lower, 1);
  EXPECT_EQ(RiseAboveZero(below).upper, 0);
  EXPECT_EQ(both.middle(), 0.5);
  EXPECT_EQ(both.magnitude(), 3);
  EXPECT_EQ((Interval{-4, 3}.magnitude()), 4);
}

using Number = Slope<double, 2>;

// of x = 3 and y = 4 each derivative by both, with those of the closed forms
TEST(Slopes, AreTheDerivatives) {
  const Number x = Variable<double, 2>(3, 0, 1), y = Variable<double, 2>(4, 1, 1);
  const auto expect = [](const Number& number, double value, double by_x, double by_y) {
    EXPECT_DOUBLE_EQ(number.value, value);
    EXPECT_DOUBLE_EQ(number.by[0], by_x);
    EXPECT_DOUBLE_EQ(number.by[1], by_y);
  };
  expect(x + y, 7, 1, 1);
  expect(x + 5.0, 8, 1, 0);
  expect(x * -2.0, -6, -2, 0);
  expect(x * y, 12, 4, 3);
  expect(x * x * y, 36, 24, 9);
  expect(x / y, 0.75, 0.25, -0.1875);
  expect(y / (x * y), 1.0 / 3, -1.0 / 9, 0);
}

using Bounds = Slope<Interval, 2>;

// bounds of value and slopes hold those of each point, here of a root, a square and a bend
TEST(Slopes, OfIntervalsHoldThoseOfTheirPoints) {
  const Bounds x = Variable<Interval, 2>({.lower = 1, .upper = 2}, 0, Interval::Of(1));
  const Bounds y = Variable<Interval, 2>({.lower = -1, .upper = 3}, 1, Interval::Of(1));
  const Bounds root = SquareRoot(x), square = Square(y), bend = AboveZero(y * x);
  for (const double at : {1.0, 1.3, 2.0}) {
    for (const double by : {-1.0, -0.5, 0.4, 3.0}) {
      EXPECT_TRUE(Holds(root.value, std::sqrt(static_cast<long double>(at))));
      EXPECT_TRUE(Holds(root.by[0], 0.5L / std::sqrt(static_cast<long double>(at))));
      EXPECT_TRUE(Holds(square.value, static_cast<long double>(by * by)));
      EXPECT_TRUE(Holds(square.by[1], static_cast<long double>(2 * by)));
      EXPECT_TRUE(Holds(bend.value, static_cast<long double>(std::max(0.0, at * by))));
      EXPECT_TRUE(Holds(bend.by[0], static_cast<long double>(by > 0 ? by : 0)));
      EXPECT_TRUE(Holds(bend.by[1], static_cast<long double>(by > 0 ? at : 0)));
    }
  }
  EXPECT_LT(root.by[1].magnitude(), 1e-300);
  EXPECT_LT(root.by[0].width(), 0.26) << "from 1/2.8 to 1/2";
  EXPECT_LT(square.by[1].width(), 8 + 1e-12) << "from -2 to 6";
}

}  // namespace
}  // namespace haptometer::sim
