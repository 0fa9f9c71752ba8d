#include "sim/piecewise/guard.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
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

}  // namespace
}  // namespace haptometer::sim
