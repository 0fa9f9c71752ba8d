#include "sim/tuning/adapter_box.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <complex>
#include <random>

#include "sim/tuning/motor_source.h"
#include "tests/sim/tuning/box_places.h"

namespace haptometer::sim {
namespace {

// |Fc / Xs|^2 of the adapter at a place of the box, whatever Ma2
double CostAt(const TuningProblem& problem, const MotorSource& source, const tests::Place& place,
              double skin_side_mass_kg, bool per_resistance) {
  const Adapter adapter = tests::AdapterAt(problem, place, skin_side_mass_kg);
  const Skin skin = SkinOf(problem, AreaAt(problem.bounds.contact_area_m2, place[3]));
  const double cost = std::norm(source.force_n / MotionOf(source, adapter, skin).skin_m);
  return per_resistance ? cost / (source.omega_rad_per_s * skin.damping_n_s_per_m) : cost;
}

class AdapterBoxes : public ::testing::TestWithParam<bool> {};

TEST_P(AdapterBoxes, HoldNothingBelowTheirBound) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> part(0, 1);
  for (const double frequency_hz : {50.0, 225.0, 500.0}) {
    TuningProblem problem = ThesisProblem();
    problem.drive.frequency_hz = frequency_hz;
    const MotorSource source = SourceOf(problem.actuator, problem.drive);
    const AdapterCost cost(problem, source, GetParam());
    for (int trial = 0; trial < 1000; ++trial) {
      const auto [box, place] = tests::RandomBox(random);
      const double mass_kg = problem.bounds.skin_side_mass_kg.At(part(random));
      ASSERT_LE(cost.Over(box).lower, CostAt(problem, source, place, mass_kg, GetParam()));
    }
  }
}

// halving a box quarters what its bound is short of the least cost at its corners and middle
TEST_P(AdapterBoxes, CloseInWithTheSquareOfTheirWidth) {
  const TuningProblem problem = ThesisProblem();
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const AdapterCost cost(problem, source, GetParam());
  const tests::Place middle{0.3, 0.6, 0.4, 0.5};
  double before = 0;
  for (const double half : {0.02, 0.01, 0.005}) {
    AdapterBox box;
    for (std::size_t axis = 0; axis < kBoxAxes; ++axis) {
      box[axis] = {middle[axis] - half, middle[axis] + half};
    }
    double least = HUGE_VAL;
    for (int corner = 0; corner < 16; ++corner) {
      AdapterBox point;
      for (std::size_t axis = 0; axis < kBoxAxes; ++axis) {
        const double at = (corner >> axis) % 2 == 0 ? box[axis].lower : box[axis].upper;
        point[axis] = Interval::Of(at);
      }
      least = std::min(least, cost.Over(point).lower);
    }
    const double gap = least - cost.Over(box).lower;
    if (before > 0) {
      EXPECT_GT(before / gap, 3.2) << half;
    }
    before = gap;
  }
}

INSTANTIATE_TEST_SUITE_P(Costs, AdapterBoxes, ::testing::Bool());

}  // namespace
}  // namespace haptometer::sim
