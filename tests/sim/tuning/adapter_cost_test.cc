#include "sim/tuning/adapter_cost.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <random>

#include "sim/linear/motor_source.h"
#include "tests/residual.h"
#include "tests/sim/tuning/box_places.h"

namespace haptometer::sim {
namespace {

using tests::Place;

TuningProblem Limited(double frequency_hz, double limit_m) {
  TuningProblem problem = ThesisProblem();
  problem.drive.frequency_hz = frequency_hz;
  problem.mover_limit_m = limit_m;
  return problem;
}

AdapterBox BoxOf(const Place& place) {
  AdapterBox box;
  for (std::size_t axis = 0; axis < kBoxAxes; ++axis) box[axis] = Interval::Of(place[axis]);
  return box;
}

// whether the cost is divided by w Bs
class AdapterCosts : public ::testing::TestWithParam<bool> {
 protected:
  // (1 - m) |Fc / Xs|^2 + m |Fc / Xs|^2 |travel|^2 / T^2 of an adapter, by its motion
  static double CostAt(const TuningProblem& problem, const MotorSource& source, const Place& place,
                       double skin_side_mass_kg, double price) {
    const Adapter adapter = tests::AdapterAt(problem, place, skin_side_mass_kg);
    const double area_m2 = AreaAt(problem.bounds.contact_area_m2, place[3]);
    double largest = 0;
    for (const Skin& skin : HardestSkins(problem, area_m2)) {
      const AdapterMotion motion = MotionOf(source, adapter, skin);
      const double part = MoverTravel(source, motion.case_m) / problem.mover_limit_m;
      const double cost = std::norm(source.force_n / motion.skin_m) *
                          (1 - price + price * part * part) /
                          (GetParam() ? source.omega_rad_per_s * skin.damping_n_s_per_m : 1);
      largest = std::max(largest, cost);
    }
    return largest;
  }
};

TEST_P(AdapterCosts, HoldNothingBelowTheirBound) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> part(0, 1);
  for (const double frequency_hz : {50.0, 225.0, 500.0}) {
    for (int trial = 0; trial < 1000; ++trial) {
      TuningProblem problem = Limited(frequency_hz, 0.2e-3);
      const bool priced = trial % 2 == 0;
      if (trial % 4 == 1) problem.skin_variation = 0.5 * part(random);
      const MotorSource source = SourceOf(problem.actuator, problem.drive);
      const double price = priced ? part(random) : 0;
      const auto [box, place] = tests::RandomBox(random);
      const double mass_kg = problem.bounds.skin_side_mass_kg.At(part(random));
      ASSERT_LE(AdapterCost(problem, source, GetParam(), price).Over(box).lower,
                CostAt(problem, source, place, mass_kg, price))
          << frequency_hz << " Hz, price " << price;
    }
  }
}

// the cost is a parabola over Ma2, here through three points of it
TEST_P(AdapterCosts, OfAPointAreTheLeastOverTheSkinSidesMass) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> part(0, 1);
  int at_a_bound = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const TuningProblem problem = Limited(100 + 400 * part(random), 0.6e-3 * part(random) + 5e-5);
    const MotorSource source = SourceOf(problem.actuator, problem.drive);
    const Place place{part(random), part(random), part(random), part(random)};
    const double price = trial % 4 == 0 ? 0 : part(random);
    const Range& mass_kg = problem.bounds.skin_side_mass_kg;
    const auto at = [&](double kg) { return CostAt(problem, source, place, kg, price); };
    const double low = at(mass_kg.lower), high = at(mass_kg.upper), mid = at(mass_kg.At(0.5));
    const double bend = 2 * (low - 2 * mid + high), slope = high - low - bend;  // over the part
    const double best = std::clamp(-slope / (2 * bend), 0.0, 1.0);
    at_a_bound += best == 0 || best == 1 ? 1 : 0;
    const BoxCost cost = AdapterCost(problem, source, GetParam(), price).Over(BoxOf(place));
    EXPECT_REL(cost.lower, at(mass_kg.At(best)), 1e-9, "the parabola's differences");
    EXPECT_REL(cost.middle, cost.lower, 1e-11, "interval arithmetic of a point");
  }
  EXPECT_GT(at_a_bound, 10);
}

TEST_P(AdapterCosts, AreNoMoreThanUnpricedWhereTheLimitIsKept) {
  std::mt19937 random(10);
  std::uniform_real_distribution<double> part(0, 1);
  const TuningProblem problem = Limited(225, 0.4e-3);
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  int kept = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Place place{part(random), part(random), part(random), part(random)};
    const double mass_kg = problem.bounds.skin_side_mass_kg.At(part(random));
    const double plain = CostAt(problem, source, place, mass_kg, 0);
    if (CostAt(problem, source, place, mass_kg, 1) > plain) continue;
    ++kept;
    for (const double price : {0.0, 0.3, 0.999}) {
      ASSERT_LE(AdapterCost(problem, source, GetParam(), price).Over(BoxOf(place)).lower, plain);
    }
  }
  EXPECT_GT(kept, 100);
}

// Halving a box quarters what its bound is short of the least cost at its corners. Unpriced the
// other bound, that of the terms' ranges, is the higher down to narrower boxes than these.
TEST_P(AdapterCosts, AreClosedInWithTheSquareOfTheBoxesWidth) {
  const TuningProblem problem = Limited(225, 0.4e-3);
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const Place middle{0.3, 0.6, 0.4, 0.5};
  const AdapterCost cost(problem, source, GetParam(), 0.3);
  double before = 0;
  for (const double half : {4e-4, 2e-4, 1e-4}) {
    AdapterBox box;
    for (std::size_t axis = 0; axis < kBoxAxes; ++axis) {
      box[axis] = {middle[axis] - half, middle[axis] + half};
    }
    double least = HUGE_VAL;
    for (int corner = 0; corner < 16; ++corner) {
      Place point{};
      for (std::size_t axis = 0; axis < kBoxAxes; ++axis) {
        point[axis] = (corner >> axis) % 2 == 0 ? box[axis].lower : box[axis].upper;
      }
      least = std::min(least, cost.Over(BoxOf(point)).lower);
    }
    const double gap = least - cost.Over(box).lower;
    if (before > 0) {
      EXPECT_GT(before / gap, 3.9) << half;
    }
    before = gap;
  }
}

// One box holds the whole ridge, along which no bound is lost: without damping of the adapter's own
// it is that of a matched load, |Fc / Xs|^2 = 4 w Bs Im kc.
TEST_P(AdapterCosts, OverTheWholeBoundsAreAMatchedLoads) {
  TuningProblem problem = ThesisProblem();
  problem.bounds.damping_n_s_per_m.lower = 0;
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  AdapterBox whole;
  whole.fill({.lower = 0, .upper = 1});
  const double b = source.omega_rad_per_s *
                   SkinOf(problem, problem.bounds.contact_area_m2.lower).damping_n_s_per_m;
  EXPECT_REL(AdapterCost(problem, source, GetParam()).Over(whole).lower,
             4 * source.stiffness_n_per_m.imag() * (GetParam() ? 1 : b), 1e-12,
             "the closed form; outward rounding");
}

INSTANTIATE_TEST_SUITE_P(PerResistance, AdapterCosts, ::testing::Bool());

// lower + (upper - lower) x, its slope the width; the mean value form of a parabola in closed form
TEST(MeanValueForm, IsTheMiddleWithTheSlopesOverTheBox) {
  AdapterBox box;
  box.fill({.lower = 0.25, .upper = 0.75});
  const auto x = Between(10, 14, box, 1);
  EXPECT_NEAR(x.value.lower, 11, 1e-14);
  EXPECT_NEAR(x.value.upper, 13, 1e-14);
  EXPECT_NEAR(x.by[1].lower, 4, 1e-14);
  EXPECT_NEAR(x.by[1].upper, 4, 1e-14);
  EXPECT_LT(x.by[0].magnitude(), 1e-300);
  const AdapterBox middle = MiddleOf(box);
  for (const Interval& axis : middle) {
    EXPECT_EQ(axis.lower, 0.5);
    EXPECT_EQ(axis.upper, 0.5);
  }
  // f = x^2 - 10 y + 50: 194 in the middle, slopes 8 x = 88 to 104 and -10
  auto f = Square(x);
  f = f + Between(0, 1, box, 2) * Interval::Of(-10) + Interval::Of(50);
  const BoxCost cost = MeanValueBound(box, f, Interval::Of(12 * 12 - 5 + 50));
  EXPECT_NEAR(cost.middle, 189, 1e-12);
  EXPECT_NEAR(cost.lower, 121 - 7.5 + 50, 1e-12) << "that of f's own range is higher";
  EXPECT_EQ(cost.trend, (std::array<int, kBoxAxes>{0, 1, -1, 0}));
  EXPECT_NEAR(cost.spread[1], 104 * 0.5, 1e-12);
  EXPECT_NEAR(cost.spread[2], 10 * 0.5, 1e-12);
  EXPECT_NEAR(cost.spread[0], 0, 1e-12);
  // without a range of its own: 189 - 104 / 4 - 10 / 4
  f.value.lower = -1e9;
  EXPECT_NEAR(MeanValueBound(box, f, Interval::Of(189)).lower, 189 - 26 - 2.5, 1e-12);
  // no cost is below 0
  EXPECT_EQ(MeanValueBound(box, f, Interval::Of(-5)).lower, 0);
}

}  // namespace
}  // namespace haptometer::sim
