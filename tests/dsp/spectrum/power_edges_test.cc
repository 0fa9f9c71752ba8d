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

}  // namespace
}  // namespace haptometer::dsp
