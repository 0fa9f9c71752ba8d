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
  const CubePoint top = SearchCube(slope, {false, false, false}, 5);
  EXPECT_EQ(top.place[0], 1);
  EXPECT_EQ(top.place[2], 0);
  EXPECT_ABS(top.place[1], 0.25, 1e-7, "a maximum is flat: the root of rounding");
}

TEST(CompassSearch, TakesTheHigherOfTwoHills) {
  const auto hills = [](const std::vector<double>& x) {
    return std::exp(-std::pow((x[0] - 0.15) / 0.1, 2)) +
           2 * std::exp(-std::pow((x[0] - 0.8) / 0.1, 2));
  };
  EXPECT_ABS(SearchCube(hills, {false}, 9).place[0], 0.8, 1e-6, "the other hill's foot");
}

TEST(CompassSearch, LeavesAFixedAxisAlone) {
  const auto hill = [](const std::vector<double>& x) { return -std::pow(x[0] - 0.5, 2); };
  EXPECT_EQ(SearchCube(hill, {false, true}, 9).place[1], 0);
}

}  // namespace
}  // namespace haptometer::sim
