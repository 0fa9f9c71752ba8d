#include "sim/tuning/search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "tests/residual.h"

namespace haptometer::sim {
namespace {

constexpr double kFree = -std::numeric_limits<double>::infinity();

// half the squared distance from `top`, under excess <= 0 along one direction
LimitedView Bowl(const CubePlace& place, const CubePlace& top, double excess,
                 const CubePlace& slopes) {
  return {.cost = (place - top).squaredNorm() / 2,
          .excess = excess,
          .cost_slopes = place - top,
          .excess_slopes = slopes};
}

TEST(BoundedClimb, EndsOnItsBoundsExactly) {
  const CubePlace top{-1, 0.25, 2, 0.5, 0.75};
  const auto view = [&](const CubePlace& x) { return Bowl(x, top, kFree, CubePlace::Zero()); };
  CubePlace upper = CubePlace::Ones();
  upper[3] = 0;  // held
  const LimitedSummit summit = ClimbWithinBounds(view, CubePlace::Zero(), upper, CubePlace::Zero());
  EXPECT_EQ(summit.place[0], 0);
  EXPECT_EQ(summit.place[2], 1);
  EXPECT_EQ(summit.place[3], 0);
  EXPECT_ABS(summit.place[1], 0.25, 1e-12, "where slopes end");
  EXPECT_EQ(summit.price, 0);
  EXPECT_TRUE(summit.kept);
}

// nearest point of the plane sum x = 2: every number falls by the same, which is the price
TEST(BoundedClimb, EndsOnItsLimitWithItsPrice) {
  const CubePlace top{0.9, 0.8, 0.7, 0.6, 0.5};
  const auto view = [&](const CubePlace& x) {
    return Bowl(x, top, x.sum() - 2, CubePlace::Ones());
  };
  const LimitedSummit summit =
      ClimbWithinBounds(view, CubePlace::Zero(), CubePlace::Ones(), CubePlace::Ones());
  for (int axis = 0; axis < kCubeAxes; ++axis) {
    EXPECT_ABS(summit.place[axis], top[axis] - 0.3, 1e-10, "the limit is met to 1e-11");
  }
  EXPECT_ABS(summit.price, 0.3, 1e-9, "rho times that");
  EXPECT_TRUE(summit.kept);
}

// along the valley x1 = x0^2 (Rosenbrock) inside a disc: on the disc's edge the gradients align
TEST(BoundedClimb, FollowsABentRidge) {
  const auto view = [](const CubePlace& x) {
    const double off = x[1] - x[0] * x[0];
    LimitedView at{.cost = 1e4 * off * off + (1 - x[0]) * (1 - x[0]),
                   .excess = x[0] * x[0] + x[1] * x[1] - 0.5};
    at.cost_slopes[0] = -4e4 * off * x[0] - 2 * (1 - x[0]);
    at.cost_slopes[1] = 2e4 * off;
    at.excess_slopes[0] = 2 * x[0];
    at.excess_slopes[1] = 2 * x[1];
    return at;
  };
  CubePlace upper = CubePlace::Zero();
  upper[0] = upper[1] = 1;
  const LimitedSummit summit = ClimbWithinBounds(view, CubePlace::Zero(), upper, CubePlace::Zero());
  EXPECT_TRUE(summit.kept);
  const LimitedView at = view(summit.place);
  EXPECT_ABS(at.excess, 0, 1e-11, "met");
  EXPECT_ABS((at.cost_slopes + summit.price * at.excess_slopes).norm(), 0, 1e-7,
             "1e4 times the last step");
  // on the edge and in the valley, but for what the price pulls it off
  EXPECT_ABS(summit.place[0], std::sqrt((std::sqrt(3) - 1) / 2), 1e-4, "the valley's steepness");
}

TEST(BoundedClimb, SaysWhereALimitCannotBeKept) {
  const auto view = [](const CubePlace& x) {
    return Bowl(x, CubePlace::Zero(), 1 + x.sum(), CubePlace::Ones());
  };
  EXPECT_FALSE(
      ClimbWithinBounds(view, CubePlace::Zero(), CubePlace::Ones(), CubePlace::Ones()).kept);
}

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

// just beyond 1e-11 a limit is not kept, just within it is
TEST(BoundedClimb, KeepsALimitToOneInTheEleventhDigit) {
  for (const auto& [excess, is_kept] :
       {std::pair{0.99e-11, true}, std::pair{1.01e-11, false}, std::pair{-1.0, true}}) {
    const double at_any_place = excess;
    const auto view = [at_any_place](const CubePlace& x) {
      return Bowl(x, CubePlace::Constant(0.5), at_any_place, CubePlace::Zero());
    };
    EXPECT_EQ(ClimbWithinBounds(view, CubePlace::Zero(), CubePlace::Ones(), CubePlace::Zero()).kept,
              is_kept)
        << excess;
  }
}

// a place with room left has no price; the summit has its cost
TEST(BoundedClimb, WithRoomLeftHasNoPrice) {
  const CubePlace top{0.3, 0.4, 0.5, 0.6, 0.7};
  const auto view = [&](const CubePlace& x) {
    LimitedView at = Bowl(x, top, x.sum() - 3, CubePlace::Ones());
    at.cost += 7;
    return at;
  };
  const LimitedSummit summit =
      ClimbWithinBounds(view, CubePlace::Zero(), CubePlace::Ones(), CubePlace::Ones());
  EXPECT_ABS((summit.place - top).norm(), 0, 1e-12, "where slopes end");
  EXPECT_EQ(summit.price, 0);
  EXPECT_ABS(summit.cost, 7, 1e-14, "rounding");
  EXPECT_TRUE(summit.kept);
}

// the answer has the box whose middle costs least, which is near the valley's least
TEST(BoxSearch, HasTheBoxThatItReached) {
  const LeastOfBoxes least =
      LeastCost([](const AdapterBox& box) { return Valley(box, 0.3); }, 2 - 1e-6, 20'000);
  EXPECT_ABS(least.reached[0].middle(), 0.3, 1e-2, "a valley of 1e-6 is 1e-3 wide");
  EXPECT_ABS(least.reached[1].middle(), 0.3, 1e-2, "a valley of 1e-6 is 1e-3 wide");
  EXPECT_EQ(least.reached[2].middle(), 0);
  EXPECT_EQ(least.reached[3].middle(), 1);
}

// a bound that nothing can raise further ends the search: within 1e-10 of the cost itself
TEST(BoxSearch, EndsWhereItsBoundIsTheCost) {
  const LeastOfBoxes least =
      LeastCost([](const AdapterBox& box) { return Valley(box, 0.5); }, 3, 1'000'000);
  EXPECT_LE(least.cost, 2);
  EXPECT_GE(least.cost, 2 * (1 - 1.01e-10));
  EXPECT_LT(least.boxes, 100'000U);
}

}  // namespace
}  // namespace haptometer::sim
