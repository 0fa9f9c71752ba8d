#include "sim/tuning/tuning_problem.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>

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

// Lindsay 2013, Tables 2.1 and 2.2, and 5 V at 225 Hz
TEST(ThesisProblem, HasTheNumbersOfItsTables) {
  const TuningProblem problem = ThesisProblem();
  const auto expect = [](const Range& range, double lower, double upper) {
    EXPECT_EQ(range.lower, lower);
    EXPECT_EQ(range.upper, upper);
  };
  expect(problem.bounds.motor_side_mass_kg, 0.25e-3, 10e-3);
  expect(problem.bounds.skin_side_mass_kg, 0.25e-3, 10e-3);
  expect(problem.bounds.stiffness_n_per_m, 2000, 12000);
  expect(problem.bounds.damping_n_s_per_m, 0.01, 0.1);
  expect(problem.bounds.contact_area_m2, 1e-6, 100e-6);
  EXPECT_EQ(problem.drive.amplitude_v, 5);
  EXPECT_EQ(problem.drive.frequency_hz, 225);
  EXPECT_EQ(problem.skin_variation, 0);
  EXPECT_FALSE(Fault(problem));
}

std::optional<FindingKind> FaultWith(const std::function<void(TuningProblem&)>& change) {
  TuningProblem problem = ThesisProblem();
  change(problem);
  return Fault(problem);
}

// of each range its two ends may be equal, but not crossed; 0 where it is allowed
TEST(TuningFaults, AreThoseOfTheBounds) {
  for (Range AdapterBounds::* range :
       {&AdapterBounds::motor_side_mass_kg, &AdapterBounds::skin_side_mass_kg,
        &AdapterBounds::stiffness_n_per_m, &AdapterBounds::damping_n_s_per_m}) {
    const auto fault_of = [&](double lower, double upper) {
      return FaultWith([&](TuningProblem& of) { of.bounds.*range = {lower, upper}; });
    };
    EXPECT_FALSE(fault_of(0.5, 0.5));
    EXPECT_EQ(fault_of(0.5, 0.4999), FindingKind::kBoundsCross);
    EXPECT_EQ(fault_of(-1e-9, 0.5), FindingKind::kBoundNegative);
  }
  const auto none = [](Range& range) { range = {0, 1}; };
  EXPECT_FALSE(FaultWith([&](TuningProblem& of) { none(of.bounds.motor_side_mass_kg); }));
  EXPECT_FALSE(FaultWith([&](TuningProblem& of) { none(of.bounds.damping_n_s_per_m); }));
  EXPECT_EQ(FaultWith([&](TuningProblem& of) { none(of.bounds.skin_side_mass_kg); }),
            FindingKind::kSkinSideMassNotPositive);
  EXPECT_EQ(FaultWith([&](TuningProblem& of) { none(of.bounds.stiffness_n_per_m); }),
            FindingKind::kStiffnessNotPositive);
}

TEST(TuningFaults, AreThoseOfTheSkin) {
  const auto variation = [](double v) {
    return FaultWith([v](TuningProblem& of) { of.skin_variation = v; });
  };
  EXPECT_FALSE(variation(0) || variation(0.999));
  EXPECT_EQ(variation(1), FindingKind::kSkinVariationOutside);
  EXPECT_EQ(variation(-0.001), FindingKind::kSkinVariationOutside);
  const auto area = [](double lower, double upper) {
    return FaultWith([&](TuningProblem& of) { of.bounds.contact_area_m2 = {lower, upper}; });
  };
  EXPECT_FALSE(area(1e-6, 100e-6) || area(5e-6, 5e-6));
  EXPECT_EQ(area(0.99e-6, 50e-6), FindingKind::kAreaOutside);
  EXPECT_EQ(area(2e-6, 101e-6), FindingKind::kAreaOutside);
  EXPECT_EQ(area(6e-6, 5e-6), FindingKind::kAreaOutside);
  const auto fixed = [](double damping) {
    return FaultWith([damping](TuningProblem& of) {
      of.fixed_skin = Skin{.stiffness_n_per_m = 600, .damping_n_s_per_m = damping};
      of.bounds.contact_area_m2 = {};  // of no meaning then
    });
  };
  EXPECT_FALSE(fixed(1e-6));
  EXPECT_EQ(fixed(0), FindingKind::kSkinUndamped);
}

TEST(TuningFaults, AreThoseOfTheTravel) {
  const auto travel = [](double limit_m) {
    return FaultWith([limit_m](TuningProblem& of) { of.mover_limit_m = limit_m; });
  };
  EXPECT_FALSE(travel(1e-9));
  EXPECT_EQ(travel(0), FindingKind::kTravelNotPositive);
  EXPECT_EQ(travel(-1e-3), FindingKind::kTravelNotPositive);
}

TEST(HardestSkins, HaveEitherStiffnessAndTheLargestDamping) {
  TuningProblem problem = ThesisProblem();
  problem.fixed_skin = Skin{.stiffness_n_per_m = 800, .damping_n_s_per_m = 2};
  problem.skin_variation = 0.25;
  const auto [softer, stiffer] = HardestSkins(problem, 1e-6);
  EXPECT_EQ(softer.stiffness_n_per_m, 600);
  EXPECT_EQ(stiffer.stiffness_n_per_m, 1000);
  EXPECT_EQ(softer.damping_n_s_per_m, 2.5);
  EXPECT_EQ(stiffer.damping_n_s_per_m, 2.5);
}

// over the area's part the skin's law is a straight line, and so between other ends
TEST(AreaAt, MakesTheSkinsLawAStraightLine) {
  const Range all{.lower = 1e-6, .upper = 100e-6}, some{.lower = 8e-6, .upper = 64e-6};
  for (const double part : {0.0, 0.2, 0.7, 1.0}) {
    const Skin skin = SkinUnderArea(AreaAt(all, part), SkinRange::kText);
    EXPECT_REL(skin.stiffness_n_per_m, 600 + 1400 * part, 1e-13, "rounding of a cube root");
    EXPECT_REL(skin.damping_n_s_per_m, 0.75 + 1.63 * part, 1e-13, "rounding of a cube root");
    EXPECT_REL(AreaAt(some, part), std::pow(0.02 + 0.02 * part, 3), 1e-14,
               "cube roots of 0.02 and 0.04");
  }
  EXPECT_EQ(AreaAt(some, 0), some.lower);
  EXPECT_EQ(AreaAt(some, 1), some.upper);
  EXPECT_EQ(AreaAt(some, 1.5), some.upper);
}

TEST(WideRange, IsOneOfMoreThanAFactorOfTwenty) {
  EXPECT_FALSE(IsWide({.lower = 1, .upper = 20}));
  EXPECT_TRUE(IsWide({.lower = 1, .upper = 20.01}));
  EXPECT_FALSE(IsWide({.lower = 0, .upper = 100}));
}

// by the logarithm where it is wide
TEST(WideRange, IsEvenOverItsLogarithm) {
  const Range wide{.lower = 1e2, .upper = 1e6}, narrow{.lower = 100, .upper = 300};
  EXPECT_REL(ScaledAt(wide, 0.5), 1e4, 1e-14, "rounding of the exponential");
  EXPECT_REL(ScaledAt(wide, 0.25), 1e3, 1e-14, "rounding of the exponential");
  EXPECT_EQ(ScaledAt(wide, 1), 1e6);
  EXPECT_EQ(ScaledAt(wide, 0), 1e2);
  EXPECT_EQ(ScaledAt(narrow, 0.5), 200);
  for (const Range& range : {wide, narrow}) {
    for (const double part : {0.0, 0.3, 1.0}) {
      EXPECT_ABS(ScaledPartOf(range, ScaledAt(range, part)), part, 1e-14, "rounding");
    }
  }
  AdapterBounds bounds = ThesisBounds();
  bounds.stiffness_n_per_m = wide;
  bounds.damping_n_s_per_m = {.lower = 1e-3, .upper = 0.1};
  const AdapterPoint point = PointOf(bounds, CubePlace::Constant(0.5));
  EXPECT_REL(point.adapter.stiffness_n_per_m, 1e4, 1e-14, "rounding of the exponential");
  EXPECT_REL(point.adapter.damping_n_s_per_m, 1e-2, 1e-14, "rounding of the exponential");
  EXPECT_REL(point.adapter.motor_side_mass_kg, 5.125e-3, 1e-15, "masses by themselves");
  EXPECT_ABS((PlaceOf(bounds, point) - CubePlace::Constant(0.5)).norm(), 0, 1e-14, "rounding");
}

// Ma1, Ka, Ba, the area, which changes first; each with parts of its own
TEST(Lattice, IsEveryCombinationInItsOrder) {
  const auto places = Lattice(CubePlace::Ones(), {{{0.1, 0.2}, {0.3}, {0.4, 0.5, 0.6}, {0.7, 1}}});
  ASSERT_EQ(places.size(), 12U);
  std::size_t k = 0;
  for (const double Ma1 : {0.1, 0.2}) {
    for (const double Ba : {0.4, 0.5, 0.6}) {
      for (const double area : {0.7, 1.0}) {
        EXPECT_EQ(places[k++], (CubePlace{Ma1, 0.3, Ba, area, 0}));
      }
    }
  }
}

}  // namespace
}  // namespace haptometer::sim
