#include "sim/steady_run.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "sim/scene_run.h"
#include "tests/residual.h"

namespace haptometer::sim {
namespace {

// a run of which the skin's position at the end of each period of the drive is known
SceneRun EndingAt(const std::vector<double>& positions_m) {
  SceneRun run;
  for (const double position_m : positions_m) {
    run.marks.push_back({.positions = Eigen::Vector2d(position_m, 1e-3)});
  }
  return run;
}

TEST(PeriodAtEnd, IsTheNumberOfDrivePeriodsAfterWhichTheMotionRepeatsItself) {
  EXPECT_EQ(PeriodAtEnd(EndingAt({2e-3, 1e-3, 1e-3, 1e-3})), 1);
  EXPECT_EQ(PeriodAtEnd(EndingAt({1e-3, 2e-3, 1e-3, 2e-3, 1e-3})), 2);
  EXPECT_EQ(PeriodAtEnd(EndingAt({1e-3, 2e-3, 3e-3, 1e-3, 2e-3, 3e-3, 1e-3})), 3);
  EXPECT_EQ(PeriodAtEnd(EndingAt({1e-3, 2e-3, 3e-3, 4e-3, 5e-3})), std::nullopt) << "it drifts";
  EXPECT_EQ(PeriodAtEnd(EndingAt({1e-3, 1e-3})), std::nullopt) << "too few to say";
}

// within 1e-4 of the largest position
TEST(PeriodAtEnd, HasATolerance) {
  EXPECT_EQ(PeriodAtEnd(EndingAt({1e-3, 1e-3, 1.00009e-3})), 1);
  EXPECT_EQ(PeriodAtEnd(EndingAt({1e-3, 1e-3, 1.00011e-3})), std::nullopt);
}

// windows of two periods whose mean squares are 4 and 1 um^2: RMS of 2 and 1 um about 1.5 um
TEST(WindowUncertainty, IsTheRelativeDeviationFromWindowToWindow) {
  SceneRun run = EndingAt({0, 0, 0, 0, 0});
  const double square_m2_s[] = {0, 2e-12, 4e-12, 4.5e-12, 5e-12};
  for (std::size_t k = 0; k < 5; ++k) run.marks[k].skin_square_m2_s = square_m2_s[k];
  EXPECT_REL(*WindowUncertainty(run, 2), std::sqrt(0.5) / 1.5, 1e-14, "rounding");
  EXPECT_EQ(WindowUncertainty(run, 3), std::nullopt) << "one window has no deviation";
}

}  // namespace
}  // namespace haptometer::sim
