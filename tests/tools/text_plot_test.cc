// A plot of characters, as the live view shows it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "tools/plot/gnuplot.h"

namespace haptometer::plot {
namespace {

TEST(TextPlot, FitsItsPlaceAndShowsTheCurve) {
  const auto drawn = DrawText({.title = "distance / mm",
                               .x_label = "time / s",
                               .y_label = "",
                               .series = {{.title = "", .x = {0, 1, 2, 3}, .y = {0, 1, 0, 1}}}},
                              60, 12);
  ASSERT_TRUE(drawn) << drawn.error().Text();
  EXPECT_THAT(*drawn, ::testing::HasSubstr("distance / mm"));
  EXPECT_THAT(*drawn, ::testing::HasSubstr("time / s"));
  EXPECT_THAT(*drawn, ::testing::HasSubstr("*"));
  EXPECT_EQ(std::ranges::count(*drawn, '\f'), 0);
  EXPECT_EQ(std::ranges::count(*drawn, '\x1b'), 0);
  int lines = 0;
  std::istringstream stream(*drawn);
  for (std::string line; std::getline(stream, line); ++lines) EXPECT_LE(line.size(), 60U) << line;
  EXPECT_LE(lines, 13);
  EXPECT_GE(lines, 11);
}

}  // namespace
}  // namespace haptometer::plot
