#include "sim/piecewise/guard.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "tests/residual.h"

namespace haptometer::sim {
namespace {

// leading * product of (u - root)
Eigen::VectorXd WithRoots(double leading, const std::vector<double>& roots) {
  Eigen::VectorXd product = Eigen::VectorXd::Constant(1, leading);
  for (const double root : roots) {
    Eigen::VectorXd next = Eigen::VectorXd::Zero(product.size() + 1);
    next.tail(product.size()) = product;
    next.head(product.size()) -= root * product;
    product = next;
  }
  return product;
}

TEST(GuardPolynomial, OneRootIsFoundToRounding) {
  const std::optional<double> place = FirstFall(WithRoots(-1, {0.3}), 0);
  ASSERT_TRUE(place.has_value());
  EXPECT_ABS(*place, 0.3, 0x1p-51, "the resolution");
  EXPECT_FALSE(FirstFall(WithRoots(1, {0.3}), 0.31).has_value()) << "it rises";
  EXPECT_EQ(FirstFall(WithRoots(1, {0.3}), 0.1), 0.1) << "below zero from the first";
}

TEST(GuardPolynomial, TwoCrossingsCloseTogetherCannotHide) {
  // at 0.7 +- d the value between is -d^2: 1e-14 at the least, above the sums' rounding
  for (const double apart : {1e-1, 1e-3, 1e-5, 1e-7}) {
    const std::optional<double> place = FirstFall(WithRoots(1, {0.7 - apart, 0.7 + apart}), 0);
    ASSERT_TRUE(place.has_value()) << apart;
    EXPECT_ABS(*place, 0.7 - apart, 1e-16 / apart, "rounding over the slope 2 d");
  }
}

TEST(GuardPolynomial, WhatStaysAboveIsClear) {
  for (const double above : {1e-2, 1e-6, 1e-10, 1e-14}) {
    Eigen::VectorXd graze = WithRoots(1, {0.7, 0.7});
    graze(0) += above;
    EXPECT_FALSE(FirstFall(graze, 0).has_value()) << above;
  }
}

TEST(GuardPolynomial, TheLastPlaceAboveIsFoundBackwards) {
  EXPECT_ABS(LastAbove(WithRoots(-1, {0.3}), 0.8), 0.3, 0x1p-50, "the resolution");
  EXPECT_ABS(LastAbove(WithRoots(1, {0.1, 0.2, 0.4}), 0.35), 0.2, 0x1p-50, "the resolution");
  EXPECT_EQ(LastAbove(WithRoots(-1, {-0.1}), 0.8), 0.8) << "never above";
}

TEST(GuardPolynomial, WhatIsNotANumberIsNoFall) {
  Eigen::VectorXd broken = WithRoots(-1, {0.3});
  broken(1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(FirstFall(broken, 0).has_value());
  EXPECT_FALSE(FirstFall(Eigen::VectorXd::Zero(5), 0).has_value());
}

TEST(GuardPolynomial, AgreesWithTheRootsThatItWasMadeOf) {
  constexpr unsigned kSeed = 20261122;
  std::mt19937_64 engine(kSeed);
  std::uniform_real_distribution<double> uniform(-0.5, 1.5);
  for (int i = 0; i < 2000; ++i) {
    std::vector<double> roots(1 + engine() % 9);
    for (double& root : roots) root = uniform(engine);
    std::ranges::sort(roots);
    const double sign = engine() % 2 == 0 ? 1 : -1;
    const std::optional<double> place = FirstFall(WithRoots(sign, roots), 0);
    // the sign at 0, then a change at each root
    bool above = sign > 0;
    for (const double root : roots) above ^= root > 0;
    std::optional<double> expected = above ? std::nullopt : std::optional(0.0);
    for (const double root : roots) {
      if (expected || root <= 0 || root > 1) continue;
      if (above) expected = root;
      above = !above;
    }
    ASSERT_EQ(place.has_value(), expected.has_value()) << "seed " << kSeed << ' ' << i;
    if (!expected) continue;
    EXPECT_ABS(*place, *expected, 1e-6, "nine roots, some nearly double");
  }
}

TEST(GuardPolynomial, ExtendsARangeByTheExtremesInside) {
  // T4(2 u - 1): 1 at u = 1/2, -1 at u = (1 -+ sqrt(1/2)) / 2
  Eigen::VectorXd chebyshev(5);
  chebyshev << 1, -32, 160, -256, 128;
  const double side = 8 * std::pow(0.4, 4) - 8 * 0.4 * 0.4 + 1;
  ValueRange middle{.least = side, .largest = side};
  ExtendRange(chebyshev, 0.3, 0.7, middle);
  EXPECT_ABS(middle.largest, 1, 1e-13, "flat over 2^-26, curvature 64");
  EXPECT_ABS(middle.least, side, 1e-13, "rounding of coefficients of 256");
  ValueRange left{.least = 1, .largest = 1};
  ExtendRange(chebyshev, 0, 0.5, left);
  EXPECT_ABS(left.least, -1, 1e-13, "flat over 2^-26, curvature 128");
  EXPECT_ABS(left.largest, 1, 1e-13, "the ends");
  // what only falls adds nothing, nor does what is no number
  ValueRange none;
  ExtendRange(chebyshev, 0, 0.1, none);
  chebyshev[2] = std::numeric_limits<double>::quiet_NaN();
  ExtendRange(chebyshev, 0, 1, none);
  EXPECT_LT(none.largest, none.least);
  EXPECT_REL(PolynomialValue(WithRoots(2, {0.5, -1, 3}), 2), 2 * 1.5 * 3 * -1, 1e-15, "rounding");
}

// ------------------------------------------------------------------------------------ the decision

// thresholds over 0.5 s: M2 h^2/8 = 0.25, M2 h/2 = 2, M2 h = 4, M3 h = 3, M4 h = 2
GuardVerdict Judged(const GuardJet& begin, const GuardJet& end) {
  return Judge(begin, end, {8, 6, 4}, 0.5);
}

constexpr GuardJet kLow{0.1, 0, 0, 0};

TEST(Judge, IsClearWhereBothEndsAreAboveTheBulge) {
  EXPECT_EQ(Judged({0.2501, 0, 0, 0}, {0.2501, 0, 0, 0}), GuardVerdict::kClear);
  EXPECT_EQ(Judged({0.2499, 0, 0, 0}, {0.2501, 0, 0, 0}), GuardVerdict::kUnknown);
  EXPECT_EQ(Judged({0.2501, 0, 0, 0}, {0.2499, 0, 0, 0}), GuardVerdict::kUnknown);
}

TEST(Judge, IsClearWhereTheGuardRisesFastEnough) {
  EXPECT_EQ(Judged({0, 2.01, 0, 0}, kLow), GuardVerdict::kClear);
  EXPECT_EQ(Judged({0, 1.99, 0, 0}, kLow), GuardVerdict::kUnknown);
  EXPECT_EQ(Judged(kLow, {0.1, 2.01, 0, 0}), GuardVerdict::kUnknown) << "at the end it is too late";
}

TEST(Judge, GoesByTheEndWhereTheGuardFallsAllTheWay) {
  for (const double below : {-0.001, -10.0}) {
    EXPECT_EQ(Judged({0.1, -4.01, 0, 0}, {below, 0, 0, 0}), GuardVerdict::kCrosses);
    EXPECT_EQ(Judged(kLow, {below, -4.01, 0, 0}), GuardVerdict::kCrosses);
    EXPECT_EQ(Judged({0.1, -3.99, 0, 0}, {below, -3.99, 0, 0}), GuardVerdict::kUnknown);
  }
  EXPECT_EQ(Judged({0.1, -4.01, 0, 0}, {0, 0, 0, 0}), GuardVerdict::kClear);
}

TEST(Judge, GoesByTheEndOfAConcaveGuard) {
  EXPECT_EQ(Judged({0.1, 1, -3.01, 0}, {-0.001, 0, 0, 0}), GuardVerdict::kCrosses);
  EXPECT_EQ(Judged(kLow, {-0.001, 0, -3.01, 0}), GuardVerdict::kCrosses);
  EXPECT_EQ(Judged({0.1, 1, -3.01, 0}, kLow), GuardVerdict::kClear);
  EXPECT_EQ(Judged({0.1, 1, -2.99, 0}, {-0.001, 0, -2.99, 0}), GuardVerdict::kUnknown);
}

TEST(Judge, AConvexGuardDipsWhereItFallsAtFirstAndRisesAtLast) {
  for (const bool at_begin : {true, false}) {
    const auto judged = [&](double second, double first_rate, double last_rate, double last) {
      return Judged({0.1, first_rate, at_begin ? second : 0, 0},
                    {last, last_rate, at_begin ? 0 : second, 0});
    };
    EXPECT_EQ(judged(3.01, 0, 1, 0.1), GuardVerdict::kClear) << "it rises from the first";
    EXPECT_EQ(judged(3.01, -0.01, 0.01, 0.1), GuardVerdict::kDips);
    EXPECT_EQ(judged(3.01, -1, -0.01, 0.1), GuardVerdict::kClear) << "it falls, to above zero";
    EXPECT_EQ(judged(3.01, -1, -0.01, -0.001), GuardVerdict::kCrosses);
    EXPECT_EQ(judged(2.99, -1, 1, 0.1), GuardVerdict::kUnknown);
  }
}

TEST(Judge, IsClearWhereAllDerivativesBeginAboveZero) {
  EXPECT_EQ(Judged({0, 0, 0, 2.01}, {0, 0, 0, 0}), GuardVerdict::kClear);
  EXPECT_EQ(Judged({0, 0, 0, 1.99}, {0, 0, 0, 5}), GuardVerdict::kUnknown);
  EXPECT_EQ(Judged({0, -0.001, 0, 2.01}, {0, 0, 0, 0}), GuardVerdict::kUnknown);
  EXPECT_EQ(Judged({0, 0, -0.001, 2.01}, {0, 0, 0, 0}), GuardVerdict::kUnknown);
}

// u = 0.2, a = 10, e = 1/2: flights of T = 2 u / (a (1 - e)) in all, the first 2 mm high
TEST(TimeToRest, IsThatOfAllFlightsWhereTheyAreLowAndTheAccelerationIsSteady) {
  const Bounce bounce{.restitution = 0.5};
  const auto rest_s = [&](double jerk, double height) {
    return TimeToRest(bounce, {0, 0.2, -10, jerk}, height);
  };
  ASSERT_TRUE(rest_s(0, 2.01e-3));
  EXPECT_REL(*rest_s(0, 2.01e-3), 0.08, 1e-15, "rounding");
  EXPECT_FALSE(rest_s(0, 1.99e-3)) << "the first flight is higher";
  // a thousandth of a within T: 0.125 a second
  for (const double sign : {1.0, -1.0}) {
    EXPECT_TRUE(rest_s(0.1245 * sign, 1));
    EXPECT_FALSE(rest_s(0.1255 * sign, 1));
  }
  EXPECT_FALSE(TimeToRest(Bounce{.restitution = 1}, {0, 0.2, -10, 0}, 1)) << "they never end";
  EXPECT_FALSE(TimeToRest(bounce, {0, 0.2, 0, 0}, 1)) << "nothing brings it back";
  EXPECT_FALSE(TimeToRest(bounce, {0, 0.2, 10, 0}, 1));
  EXPECT_EQ(TimeToRest(bounce, {0, -1e-9, -10, 0}, 0), 0) << "rounding of no speed";
}

// -------------------------------------------------------------------------------------- the bounds

constexpr double kPace = 30;  // rad/s

ExcitationShape SineShape() {
  ExcitationShape shape{.generator = Eigen::Matrix2d::Zero(),
                        .rows = Eigen::MatrixXd::Zero(kInputs, 2),
                        .pairs = {0}};
  shape.generator << 0, kPace, -kPace, 0;
  return shape;
}

// [x, v / w] of an oscillation at w, under a sine that does not reach it
Eigen::MatrixXd Oscillating(double omega) {
  Eigen::MatrixXd generator = Eigen::MatrixXd::Zero(4, 4);
  generator(0, 1) = omega;
  generator(1, 0) = -omega;
  generator.bottomRightCorner(2, 2) = SineShape().generator;
  return generator;
}

// x' = -a x + b sin w t, g = 2 x + 3 sin w t + 4
TEST(GuardBound, HasTheDerivativesOfTheClosedForm) {
  constexpr double a = 7, b = 5, w = kPace;
  Eigen::MatrixXd generator = Eigen::MatrixXd::Zero(3, 3);
  generator(0, 0) = -a;
  generator(0, 1) = b;
  generator.bottomRightCorner(2, 2) = SineShape().generator;
  const GuardBound bound(generator, Eigen::RowVector3d(2, 3, 0), 4, SineShape(), 0.01);
  const double x = 0.7, s = 0.6, c = 0.8;
  const Eigen::VectorXd state = Eigen::VectorXd::Constant(1, x);
  const Eigen::VectorXd signals = Eigen::Vector2d(s, c);
  EXPECT_REL(bound.Value(state, signals), 2 * x + 3 * s + 4, 1e-15, "order of the sum");
  const GuardJet jet = bound.Jet(state, signals);
  const double rate = -a * x + b * s, second = -a * rate + b * w * c;
  EXPECT_EQ(jet[0], bound.Value(state, signals));
  EXPECT_REL(jet[1], 2 * rate + 3 * w * c, 1e-14, "rounding");
  EXPECT_REL(jet[2], 2 * second - 3 * w * w * s, 1e-14, "rounding");
  EXPECT_REL(jet[3], 2 * (-a * second - b * w * w * s) - 3 * w * w * w * c, 1e-14, "rounding");
}

TEST(GuardBound, ReachesAsFarAs256PointsOfTheGrid) {
  EXPECT_REL(GuardBound::LongestHorizon(Oscillating(200)), 64 / 200.0, 1e-15, "|G|_1 = w");
  EXPECT_REL(GuardBound::LongestHorizon(Oscillating(3)), 64 / kPace, 1e-15, "that of the sine");
}

TEST(GuardBound, NoiseCountsTheTermsOfTheStateAndTheOffset) {
  const GuardBound bound(Oscillating(200), Eigen::RowVector4d(2, -3, 50, 0), -7, SineShape(), 0.01);
  EXPECT_EQ(bound.Noise(Eigen::Vector2d(0.5, 0.25)), std::ldexp(1 + 0.75 + 7, -44));
}

// x = exp(-a t): the k-th derivative is a^k at most, at the beginning
TEST(GuardBound, OfADecayIsWhatItBeginsWith) {
  constexpr double a = 400;
  Eigen::MatrixXd generator = Eigen::MatrixXd::Zero(3, 3);
  generator(0, 0) = -a;
  generator.bottomRightCorner(2, 2) = SineShape().generator;
  GuardBound bound(generator, Eigen::RowVector3d(1, 0, 0), 0, SineShape(), 0.1);
  const GuardBounds bounds = bound.Bounds(Eigen::VectorXd::Ones(1), Eigen::Vector2d(1, 0));
  for (std::size_t k = 0; k < 3; ++k) {
    const double largest = std::pow(a, static_cast<double>(k) + 2);
    EXPECT_GE(bounds[k], largest);
    EXPECT_LE(bounds[k], 1.285 * largest) << "exp(1/4) for what lies between points of the grid";
  }
}

// over three turns each state comes to its magnitude, and a sine to its amplitude at any phase
TEST(GuardBound, HoldsOverItsHorizonWithoutWaste) {
  constexpr double w = 200;
  GuardBound of_state(Oscillating(w), Eigen::RowVector4d(1, 0, 0, 0), 0, SineShape(), 20 / w);
  GuardBound of_sine(Oscillating(w), Eigen::RowVector4d(0, 0, 3, 0), 0, SineShape(), 20 / w);
  const Eigen::Vector2d none(0, 0), sine(1, 0);
  for (std::size_t k = 0; k < 3; ++k) {
    const double order = static_cast<double>(k) + 2;
    for (const Eigen::Vector2d& start : {Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 1)}) {
      const double bound = of_state.Bounds(start, none)[k];
      EXPECT_GE(bound, std::pow(w, order));
      EXPECT_LE(bound, 1.285 * std::pow(w, order)) << "exp(1/4)";
    }
    const double bound = of_sine.Bounds(none, sine)[k];
    EXPECT_GE(bound, 3 * std::pow(kPace, order));
    EXPECT_LE(bound, 1.05 * std::numbers::sqrt2 * 3 * std::pow(kPace, order))
        << "a pair's two entries; exp(1/4 30/200)";
  }
  EXPECT_EQ(of_state.SecondBound(Eigen::Vector2d(1, 0), none),
            of_state.Bounds(Eigen::Vector2d(-1, 0), none)[0]);
  // a state that does not come to its largest within a hundredth of a turn
  const GuardBound brief(Oscillating(w), Eigen::RowVector4d(1, 0, 0, 0), 0, SineShape(), 0.06 / w);
  EXPECT_GE(brief.SecondBound(Eigen::Vector2d(0, 1), none), w * w * std::sin(0.06));
  EXPECT_LE(brief.SecondBound(Eigen::Vector2d(0, 1), none), 1.01 * w * w * std::sinh(0.06));
}

}  // namespace
}  // namespace haptometer::sim
