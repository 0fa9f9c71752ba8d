#include "fit/least_squares.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace haptometer::fit {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// r = (p - 3, 2 p) with what a test does to it
LeastSquares Line(bool is_defined, double slope) {
  return {.residuals = 2,
          .parameters = 1,
          .evaluate = [=](std::span<const double> point, std::span<double> r,
                          std::span<double> jacobian) {
            r[0] = point[0] - 3;
            r[1] = 2 * point[0];
            if (!jacobian.empty()) {
              jacobian[0] = slope;
              jacobian[1] = 2;
            }
            return is_defined;
          }};
}

// (p - 3)^2 + 4 p^2 is least at p = 3/5
TEST(LeastSquares, FindsTheLeastOfALine) {
  std::vector<double> point{40};
  EXPECT_TRUE(Minimise(Line(true, 1), {true}, &point).converged);
  EXPECT_NEAR(point[0], 0.6, 1e-15) << "one rounding of the closed form";
}

// the solver's library writes of its own on stderr; a failure is the report's alone
TEST(LeastSquares, WritesNothingWhereItFails) {
  for (const auto& problem : {Line(false, 1), Line(true, kNan), Line(true, -1e300)}) {
    std::vector<double> point{40};
    ::testing::internal::CaptureStderr();
    const SolverReport report = Minimise(problem, {true}, &point);
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    EXPECT_FALSE(report.converged);
    EXPECT_FALSE(report.termination.empty());
  }
}

}  // namespace
}  // namespace haptometer::fit
