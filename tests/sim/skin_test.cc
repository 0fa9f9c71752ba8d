#include "sim/skin.h"

#include <gtest/gtest.h>

#include "tests/residual.h"

namespace haptometer::sim {
namespace {

constexpr const char* kEnds = "ends of the law, rounding";

TEST(SkinUnderArea, RunsFromEndToEnd) {
  for (const SkinRange range : {SkinRange::kText, SkinRange::kTable}) {
    EXPECT_EQ(SkinUnderArea(1e-6, range).stiffness_n_per_m, 600);
    EXPECT_EQ(SkinUnderArea(1e-6, range).damping_n_s_per_m, 0.75);
    EXPECT_REL(SkinUnderArea(100e-6, range).damping_n_s_per_m, 2.38, 3e-16, kEnds);
  }
  EXPECT_REL(SkinUnderArea(100e-6, SkinRange::kText).stiffness_n_per_m, 2000, 3e-16, kEnds);
  EXPECT_REL(SkinUnderArea(100e-6, SkinRange::kTable).stiffness_n_per_m, 1200, 3e-16, kEnds);
}

TEST(SkinUnderArea, RunsWithTheCubeRoot) {
  // 27 mm2: cube roots 1, 3, 100^(1/3)
  const double part = (3.0 - 1) / (4.641588833612779 - 1);
  const Skin skin = SkinUnderArea(27e-6, SkinRange::kTable);
  EXPECT_REL(skin.stiffness_n_per_m, 600 + 600 * part, 1e-15, "rounding");
  EXPECT_REL(skin.damping_n_s_per_m, 0.75 + 1.63 * part, 1e-15, "rounding");
}

TEST(SkinUnderArea, OfTheBareCaseIsTheWorkedNumber) {
  const Skin text = SkinUnderArea(78.5e-6, SkinRange::kText);
  EXPECT_ABS(text.stiffness_n_per_m, 1861.7, 0.05, "sim/skin.h, one decimal");
  EXPECT_ABS(text.damping_n_s_per_m, 2.2189, 5e-5, "sim/skin.h, four decimals");
  EXPECT_ABS(SkinUnderArea(78.5e-6, SkinRange::kTable).stiffness_n_per_m, 1140.7, 0.05,
             "600 + 600 x 0.90119");
}

TEST(SkinUnderAreaDeath, CoversOnlyItsAreas) {
  EXPECT_DEATH(static_cast<void>(SkinUnderArea(0.9e-6, SkinRange::kText)), "check failed");
  EXPECT_DEATH(static_cast<void>(SkinUnderArea(101e-6, SkinRange::kText)), "check failed");
}

}  // namespace
}  // namespace haptometer::sim
