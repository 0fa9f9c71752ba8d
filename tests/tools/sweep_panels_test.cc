#include "tools/fit/sweep_panels.h"

#include <gtest/gtest.h>

namespace haptometer::tools {
namespace {

TEST(SweepPanels, PointsAndFitHaveTheirOwnFrequencies) {
  const plot::Panel panel = SweepPanel("a contact", "amplitude / um", {{40, 80}, {1, 2}},
                                       {{40, 60, 80}, {1.1, 1.5, 1.9}}, plot::LogAxes::kBoth);
  EXPECT_EQ(panel.title, "a contact");
  EXPECT_EQ(panel.log_axes, plot::LogAxes::kBoth);
  ASSERT_EQ(panel.series.size(), 2U);
  EXPECT_EQ(panel.series[0].y, (std::vector<double>{1, 2}));
  EXPECT_EQ(panel.series[1].x, (std::vector<double>{40, 60, 80}));
  EXPECT_TRUE(panel.series[0].style.starts_with("points"));
  EXPECT_TRUE(panel.series[1].style.starts_with("lines"));
}

TEST(SweepPanels, ResidualsOfTwoQuantitiesStayApart) {
  const plot::Panel panel =
      SweepResidualPanel("left", "residual / noise", {40, 80},
                         {{"magnitude", {-1, 1}}, {"phase", {0.5, 0}}}, plot::LogAxes::kX);
  ASSERT_EQ(panel.series.size(), 2U);
  EXPECT_EQ(panel.series[1].title, "phase");
  EXPECT_EQ(panel.series[1].y[0], 0.5);
  EXPECT_NE(panel.series[0].style, panel.series[1].style);
}

}  // namespace
}  // namespace haptometer::tools
