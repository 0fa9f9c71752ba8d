#include "sim/tuning/priced_cost.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>

#include "tests/residual.h"
#include "tests/sim/tuning/box_places.h"

namespace haptometer::sim {
namespace {

using tests::Place;

// (1 - m) |Fc / Xs|^2 + m |Fc / Xs|^2 |travel|^2 / T^2 of an adapter, by its motion
double PricedAt(const TuningProblem& problem, const MotorSource& source, const Place& place,
                double skin_side_mass_kg, double price) {
  const Adapter adapter = tests::AdapterAt(problem, place, skin_side_mass_kg);
  const Skin skin = SkinOf(problem, AreaAt(problem.bounds.contact_area_m2, place[3]));
  const AdapterMotion motion = MotionOf(source, adapter, skin);
  const double cost = std::norm(source.force_n / motion.skin_m);
  const double part = MoverTravel(source, motion.case_m) / problem.mover_limit_m;
  return cost * (1 - price + price * part * part);
}

TuningProblem Limited(double frequency_hz, double limit_m) {
  TuningProblem problem = ThesisProblem();
  problem.drive.frequency_hz = frequency_hz;
  problem.mover_limit_m = limit_m;
  return problem;
}

TEST(PricedCost, HoldsNothingBelowItsBound) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> part(0, 1);
  for (const double frequency_hz : {60.0, 225.0, 500.0}) {
    const TuningProblem problem = Limited(frequency_hz, 0.2e-3);
    const MotorSource source = SourceOf(problem.actuator, problem.drive);
    const PricedCost cost(problem, source, false);
    for (int trial = 0; trial < 600; ++trial) {
      const auto [box, place] = tests::RandomBox(random);
      const double mass_kg = problem.bounds.skin_side_mass_kg.At(part(random));
      const double price = part(random);
      ASSERT_LE(cost.Over(box, price).lower, PricedAt(problem, source, place, mass_kg, price));
    }
  }
}

// the priced cost is a parabola over Ma2, here through three points of it
TEST(PricedCost, OfAPointIsTheLeastOverTheSkinSidesMass) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> part(0, 1);
  int at_a_bound = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const TuningProblem problem = Limited(100 + 400 * part(random), 0.6e-3 * part(random) + 5e-5);
    const MotorSource source = SourceOf(problem.actuator, problem.drive);
    const Place place{part(random), part(random), part(random), part(random)};
    const double price = part(random);
    AdapterBox point;
    for (std::size_t axis = 0; axis < kBoxAxes; ++axis) point[axis] = Interval::Of(place[axis]);
    const Range& mass_kg = problem.bounds.skin_side_mass_kg;
    const auto at = [&](double kg) { return PricedAt(problem, source, place, kg, price); };
    const double low = at(mass_kg.lower), high = at(mass_kg.upper), mid = at(mass_kg.At(0.5));
    const double bend = 2 * (low - 2 * mid + high), slope = high - low - bend;  // over the part
    const double best = std::clamp(-slope / (2 * bend), 0.0, 1.0);
    at_a_bound += best == 0 || best == 1 ? 1 : 0;
    EXPECT_REL(PricedCost(problem, source, false).Over(point, price).lower, at(mass_kg.At(best)),
               1e-9, "the parabola's differences");
  }
  EXPECT_GT(at_a_bound, 10);
}

TEST(PricedCost, IsNoMoreThanTheCostWhereTheLimitIsKept) {
  std::mt19937 random(10);
  std::uniform_real_distribution<double> part(0, 1);
  const TuningProblem problem = Limited(225, 0.4e-3);
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const PricedCost cost(problem, source, false);
  int kept = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Place place{part(random), part(random), part(random), part(random)};
    const double mass_kg = problem.bounds.skin_side_mass_kg.At(part(random));
    const double plain = PricedAt(problem, source, place, mass_kg, 0);
    if (PricedAt(problem, source, place, mass_kg, 1) > plain) continue;
    ++kept;
    AdapterBox point;
    for (std::size_t axis = 0; axis < kBoxAxes; ++axis) point[axis] = Interval::Of(place[axis]);
    for (const double price : {0.0, 0.3, 1.0}) ASSERT_LE(cost.Over(point, price).lower, plain);
  }
  EXPECT_GT(kept, 100);
}

}  // namespace
}  // namespace haptometer::sim
