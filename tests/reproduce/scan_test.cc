#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/residual.h"
#include "tools/reproduce/thesis_model.h"

namespace haptometer::tools {
namespace {

TEST(LargestAt, FindsTheHigherOfTwoPeaks) {
  const auto two = [](double x) {
    return std::exp(-1e3 * (x - 0.3) * (x - 0.3)) + 1.01 * std::exp(-1e3 * (x - 0.7) * (x - 0.7));
  };
  EXPECT_ABS(LargestAt(two, 0, 1), 0.7, 1e-7, "a flat top: root of the rounding");
}

TEST(LargestAt, MayBeAtAnEnd) {
  EXPECT_ABS(LargestAt([](double x) { return x; }, -1, 2), 2, 1e-8, "golden section");
  EXPECT_ABS(LargestAt([](double x) { return -x; }, -1, 2), -1, 1e-8, "golden section");
}

TEST(CrossingOf, IsTheLastBeforeTheUpperEnd) {
  const auto sine = [](double x) { return std::sin(x); };
  EXPECT_ABS(CrossingOf(sine, 1, 7).value_or(0), 2 * std::numbers::pi, 1e-15, "the last digit");
  EXPECT_FALSE(CrossingOf(sine, 1, 3).has_value());
}

}  // namespace
}  // namespace haptometer::tools
