#include "sim/tuning/compass_search.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/residual.h"

namespace haptometer::sim {
namespace {

TEST(CompassSearch, FindsTheTopOfASkewHill) {
  const auto hill = [](const std::vector<double>& x) {
    const double u = x[0] - 0.3, v = x[1] - 0.7;
    return -(u * u + 1.6 * u * v + v * v);
  };
  const CubePoint top = ClimbWithinCube(hill, {0, 0});
  EXPECT_ABS(top.place[0], 0.3, 1e-8, "the last step, times the hill's skew");
  EXPECT_ABS(top.place[1], 0.7, 1e-8, "the last step, times the hill's skew");
}

TEST(CompassSearch, MeetsABoundExactly) {
  const auto slope = [](const std::vector<double>& x) {
    return x[0] - std::pow(x[1] - 0.25, 2) - 3 * x[2];
  };
  const CubePoint top = ClimbWithinCube(slope, {0.5, 0.5, 0.5});
  EXPECT_EQ(top.place[0], 1);
  EXPECT_EQ(top.place[2], 0);
  EXPECT_ABS(top.place[1], 0.25, 1e-7, "a maximum is flat: the root of rounding");
}

// A narrow ridge askew to all neighbours, which only steps of 1e-9 follow: without a bound on moves
// 2e7 evaluations are not enough. After a million the hill is taken away.
TEST(CompassSearch, EndsOnANarrowRidge) {
  int evaluations = 0;
  const auto ridge = [&](const std::vector<double>& x) {
    if (++evaluations > 1'000'000) return 0.0;
    return 1 + 1e-3 * x[0] - 1e6 * std::pow(x[1] - 0.37 * x[0], 2);
  };
  const CubePoint top = ClimbWithinCube(ridge, {0, 0});
  EXPECT_LT(evaluations, 350'000) << "37 lengths of 1000 moves with 9 evaluations at most";
  EXPECT_GE(top.value, 1);
}

}  // namespace
}  // namespace haptometer::sim
