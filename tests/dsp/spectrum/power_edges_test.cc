#include "dsp/spectrum/power_edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

const PowerCells kCells{.start_s = 2, .cell_s = 1e-3, .window_s = 0.05, .bandwidth_hz = 480};

// mean squares of cells: `noise`, and 1 more between two times after the first cell's begin
std::vector<double> Step(double noise, double from_s, double to_s) {
  std::vector<double> power(1000, noise);
  for (std::size_t k = 0; k < power.size(); ++k) {
    const double begin_s = static_cast<double>(k) * kCells.cell_s;
    const double on_s = std::min(begin_s + kCells.cell_s, to_s) - std::max(begin_s, from_s);
    power[k] += std::max(0.0, on_s) / kCells.cell_s;
  }
  return power;
}

TEST(RefinedEdges, PlaceAStepWithinACell) {
  const std::vector<double> power = Step(0, 0.3004, 0.7);
  const auto edges = RefinedEdges(power, kCells, 1e-4, PowerEdges(power, kCells));
  ASSERT_EQ(edges.size(), 2U);
  EXPECT_TRUE(edges[0].rises);
  EXPECT_FALSE(edges[1].rises);
  EXPECT_ABS(edges[0].time_s, 2.3004, 1e-5, "a parabola by its chord over one of 50 cells");
  EXPECT_ABS(edges[1].time_s, 2.7, 1e-5, "the same");
  EXPECT_REL(edges[0].uncertainty_s, 1e-4, 1e-9, "no noise; sums of the moving means");
}

// u^2 = unknown^2 + (w / B) q (1 + q)
TEST(RefinedEdges, NoiseAddsToTheUncertainty) {
  const std::vector<double> power = Step(0.5, 0.3, 0.7);
  const auto edges = RefinedEdges(power, kCells, 1e-4, PowerEdges(power, kCells));
  ASSERT_EQ(edges.size(), 2U);
  EXPECT_REL(edges[0].uncertainty_s, std::hypot(1e-4, std::sqrt(0.05 / 480 * 0.75)), 1e-9,
             "sums of the moving means");
}

// A burst shorter than the levels beside its edges are measured over: they stay as they were.
TEST(RefinedEdges, EdgesTooNearStayAsTheyWere) {
  const std::vector<double> power = Step(0, 0.5, 0.6);
  const auto coarse = PowerEdges(power, kCells);
  const auto edges = RefinedEdges(power, kCells, 1e-4, coarse);
  ASSERT_EQ(edges.size(), 2U);
  for (std::size_t k = 0; k < edges.size(); ++k) {
    EXPECT_EQ(edges[k].time_s, coarse[k].time_s);
    EXPECT_REL(edges[k].uncertainty_s, 0.025 / std::numbers::sqrt3, 1e-12, "half a window");
  }
}

// whether all edges of a burst between two times are refined
bool IsRefined(double from_s, double to_s) {
  const std::vector<double> power = Step(0, from_s, to_s);
  const auto edges = RefinedEdges(power, kCells, 1e-4, PowerEdges(power, kCells));
  EXPECT_FALSE(edges.empty());
  return std::ranges::all_of(edges, [](const PowerEdge& edge) {
    return edge.uncertainty_s < 2e-4;  // 0.1 ms refined, 14 ms as it was
  });
}

// 2.5 windows of 50 ms, to within a cell of 1 ms of each coarse edge
TEST(RefinedEdges, AreTwoAndAHalfWindowsFromEachOtherAndFromTheEnds) {
  EXPECT_FALSE(IsRefined(0.45, 0.45 + 0.123));
  EXPECT_TRUE(IsRefined(0.45, 0.45 + 0.128));
  EXPECT_FALSE(IsRefined(0.122, 2));
  EXPECT_TRUE(IsRefined(0.128, 2));
  EXPECT_TRUE(IsRefined(-1, 0.872));
  EXPECT_FALSE(IsRefined(-1, 0.878));
}

TEST(PowerEdges, AreWhereTheMovingMeanIsHalfOfTheTop) {
  const auto edges = PowerEdges(Step(0, 0.3, 0.7), kCells);
  ASSERT_EQ(edges.size(), 2U);
  EXPECT_TRUE(edges[0].rises);
  EXPECT_FALSE(edges[1].rises);
  EXPECT_ABS(edges[0].time_s, 2.3, 1.01e-3, "a cell");
  EXPECT_ABS(edges[1].time_s, 2.7, 1.01e-3, "a cell");
  EXPECT_REL(edges[0].uncertainty_s, 0.025 / std::numbers::sqrt3, 1e-12, "half a window");
  EXPECT_TRUE(PowerEdges(std::vector<double>(99, 1.0), kCells).empty()) << "below two windows";
}

// a drive of 2 % of a record that is exactly 0 elsewhere: half of the top is 0, and so are the
// means of windows behind the drive, whatever was in those before
TEST(PowerEdges, BehindAShortDriveZeroIsOff) {
  std::vector<double> power(1000, 0.0);
  for (std::size_t k = 600; k < 620; ++k) power[k] = 1.1 + std::sin(static_cast<double>(k * k));
  const auto edges = PowerEdges(power, kCells);
  ASSERT_EQ(edges.size(), 2U);
  EXPECT_TRUE(edges[0].rises);
  EXPECT_FALSE(edges[1].rises);
  EXPECT_ABS(edges[0].time_s, 2.6, 0.0251, "half a window");
  EXPECT_ABS(edges[1].time_s, 2.62, 0.0261, "half a window");
}

// One cell of 40 times the step, 47.5 ms before it, is a peak of p = 0.8 of the step there; 75 ms
// before it remains 0.36, so that the middle is 0.68. The smoothed powers cross it behind the peak
// and at the step, where 1 - (1 - t/w)^2 / 2 = 0.68: t = 10 ms.
TEST(RefinedEdges, OfSeveralCrossingsTheNearestCounts) {
  std::vector<double> power = Step(0, 0.5, 2);
  power[452] += 40;
  const auto edges = RefinedEdges(power, kCells, 1e-4, {{2.5, true, 0.014}});
  ASSERT_EQ(edges.size(), 1U);
  EXPECT_ABS(edges[0].time_s, 2.51, 1e-3, "a cell");
}

// an edge that falls has the same uncertainty as one that rises
TEST(RefinedEdges, NoiseAddsToTheUncertaintyOfEveryEdge) {
  const std::vector<double> power = Step(0.2, 0.3, 0.7);
  const auto edges = RefinedEdges(power, kCells, 1e-3, PowerEdges(power, kCells));
  ASSERT_EQ(edges.size(), 2U);
  for (const PowerEdge& edge : edges) {
    EXPECT_REL(edge.uncertainty_s, std::hypot(1e-3, std::sqrt(0.05 / 480 * 0.2 * 1.2)), 1e-9,
               "sums of the moving means");
  }
}

// Windows of 50 cells: a step at 0.3 s is in 25 of the one from cell 275 on, exactly half, and of
// a first cell of 0.1 in 25.1 of the one from cell 276 on.
TEST(PowerEdges, AreOfTheCellInWhichTheMeanPassesHalf) {
  for (const double factor : {1.0, 8.0}) {
    for (const double from_s : {0.3, 0.3009}) {
      std::vector<double> power = Step(0, from_s, 0.7);
      for (double& cell : power) cell *= factor;
      const auto edges = PowerEdges(power, kCells);
      ASSERT_EQ(edges.size(), 2U) << from_s;
      EXPECT_TRUE(edges[0].rises);
      EXPECT_FALSE(edges[1].rises);
      EXPECT_REL(edges[0].time_s, 2.301, 1e-12, "rounding");
      EXPECT_REL(edges[1].time_s, 2.7, 1e-12, "rounding");
    }
  }
}

// two windows are the fewest, and the second mean is the first that may be an edge
TEST(PowerEdges, OfTwoWindowsIsOne) {
  std::vector<double> power(100, 1.0);
  std::fill_n(power.begin(), 25, 0.0);
  const auto edges = PowerEdges(power, kCells);
  ASSERT_EQ(edges.size(), 1U);
  EXPECT_TRUE(edges[0].rises);
  EXPECT_REL(edges[0].time_s, 2.026, 1e-12, "rounding");
}

// coarse edges lie at 1 ms behind a rise and at a fall
TEST(RefinedEdges, LimitsAreThoseOfTheCells) {
  EXPECT_FALSE(IsRefined(0.45, 0.45 + 0.1245)) << "124 ms apart";
  EXPECT_TRUE(IsRefined(0.45, 0.45 + 0.1265)) << "126 ms apart";
  // 76 smoothed powers beside an edge, of 99 cells each
  EXPECT_FALSE(IsRefined(0.124, 2));
  EXPECT_TRUE(IsRefined(0.125, 2));
  EXPECT_TRUE(IsRefined(-1, 0.875));
  EXPECT_FALSE(IsRefined(-1, 0.876));
}

// the mirror image of the case above: here the nearest crossing comes first
TEST(RefinedEdges, OfSeveralCrossingsTheNearestCountsOnEitherSide) {
  std::vector<double> power = Step(0, 0.5, 2);
  power[452] += 40;
  std::ranges::reverse(power);
  const auto edges = RefinedEdges(power, kCells, 1e-4, {{2.5, false, 0.014}});
  ASSERT_EQ(edges.size(), 1U);
  EXPECT_ABS(edges[0].time_s, 2.49, 1e-3, "a cell");
}

// q is a ratio: the unit of the power does not matter
TEST(RefinedEdges, UncertaintyIsOfTheNoisesShare) {
  std::vector<double> power = Step(0.5, 0.3, 0.7);
  for (double& cell : power) cell *= 8;
  for (const PowerEdge& edge : RefinedEdges(power, kCells, 1e-4, PowerEdges(power, kCells))) {
    EXPECT_REL(edge.uncertainty_s, std::hypot(1e-4, std::sqrt(0.05 / 480 * 0.75)), 1e-9,
               "sums of the moving means");
  }
}

}  // namespace
}  // namespace haptometer::dsp
