#include "sim/tuning/tuning_problem.h"

#include <gtest/gtest.h>

#include "tests/residual.h"

namespace haptometer::sim {
namespace {

TEST(CubePlace, LeadsToAnAdapterAndBack) {
  const AdapterBounds bounds = ThesisBounds();
  const CubePlace place{0.1, 0.35, 0.6, 0.85, 0.95};
  const AdapterPoint point = PointOf(bounds, place);
  EXPECT_REL(point.adapter.motor_side_mass_kg, 1.225e-3, 1e-15, "0.25 and a tenth of 9.75 g");
  EXPECT_REL(point.adapter.stiffness_n_per_m, 5500, 1e-15, "2000 and 0.35 of 10 000 N/m");
  const CubePlace back = PlaceOf(bounds, point);
  for (int axis = 0; axis < kCubeAxes; ++axis) {
    EXPECT_ABS(back[axis], place[axis], 1e-15, "a few roundings");
  }
}

TEST(CubePlace, OfAHeldAxisIsNought) {
  TuningProblem problem = ThesisProblem();
  problem.bounds.stiffness_n_per_m = {9000, 9000};
  EXPECT_EQ(UpperEndOf(problem), (CubePlace{1, 0, 1, 1, 1}));
  problem.fixed_skin = Skin{.stiffness_n_per_m = 600, .damping_n_s_per_m = 0.75};
  const CubePlace upper = UpperEndOf(problem);
  EXPECT_EQ(upper, (CubePlace{1, 0, 1, 0, 1}));
  EXPECT_EQ(PartOf(problem.bounds.stiffness_n_per_m, 9000), 0);
  const auto places = Lattice(upper, {{{0, 0.5, 1}, {0, 1}, {0, 1}, {0, 1}}});
  ASSERT_EQ(places.size(), 6U) << "three of Ma1, two of Ba";
  EXPECT_EQ(places.front(), CubePlace::Zero());
  EXPECT_EQ(places.back(), (CubePlace{1, 0, 1, 0, 0}));
}

}  // namespace
}  // namespace haptometer::sim
