#include "sim/tuning/box_search.h"

#include <gtest/gtest.h>

namespace haptometer::sim {
namespace {

using Number = Slope<Interval, kBoxAxes>;

Number Axis(const AdapterBox& box, std::size_t axis) {
  return Variable<Interval, kBoxAxes>(box[axis], axis, Interval::Of(1));
}

// u^2 + v^2 - 1.2 u v + x2 (x0 + 0.1) + (1 - x3) (x1 + 0.1) + 2, u = x0 - c, v = x1 - c: the least,
// 2, at x0 = x1 = c, x2 = 0, x3 = 1
BoxCost Valley(const AdapterBox& box, double c) {
  const auto at = [c](const AdapterBox& where) {
    const Interval minus_c = Interval::Of(-c), tenth = Interval::Of(0.1);
    const Number u = Axis(where, 0) + minus_c, v = Axis(where, 1) + minus_c;
    return Square(u) + Square(v) + u * v * Interval::Of(-1.2) +
           Axis(where, 2) * (Axis(where, 0) + tenth) +
           (Axis(where, 3) * Interval::Of(-1) + Interval::Of(1)) * (Axis(where, 1) + tenth) +
           Interval::Of(2);
  };
  return MeanValueBound(box, at(box), at(MiddleOf(box)).value);
}

TEST(BoxSearch, ClosesInOnTheLeastFromBelow) {
  for (const double c : {0.0, 0.3, 0.5, 1.0}) {
    const LeastOfBoxes least =
        LeastCost([c](const AdapterBox& box) { return Valley(box, c); }, 2 - 1e-6, 20'000);
    EXPECT_LE(least.cost, 2) << c;
    EXPECT_GE(least.cost, 2 - 1e-6) << c;
    EXPECT_GT(least.boxes, 1U);
  }
}

TEST(BoxSearch, FlattensWhatOnlyRises) {
  // without flattening x2 and x3 every valley's box would be cut along them too
  const LeastOfBoxes least =
      LeastCost([](const AdapterBox& box) { return Valley(box, 0.3); }, 2 - 1e-6, 20'000);
  EXPECT_LT(least.boxes, 400U);
}

TEST(BoxSearch, StopsAtTheMostBoxes) {
  const LeastOfBoxes least =
      LeastCost([](const AdapterBox& box) { return Valley(box, 0.3); }, 3, 11);
  EXPECT_LE(least.cost, 2);
  EXPECT_EQ(least.boxes, 11U);
}

}  // namespace
}  // namespace haptometer::sim
