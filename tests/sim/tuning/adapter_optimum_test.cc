#include "sim/tuning/adapter_optimum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "sim/tuning/adapter_grid.h"
#include "sim/tuning/travel_limit.h"
#include "tests/residual.h"
#include "tests/sim/tuning/adapter_reference.h"

namespace haptometer::sim {
namespace {

constexpr const char* kFlat = "a maximum is flat: the root of rounding";
constexpr const char* kRounding = "mpmath; rounding";

AdapterPoint Anywhere(const AdapterBounds& bounds, std::mt19937& random) {
  std::uniform_real_distribution<double> part(0, 1);
  return {.adapter = {.motor_side_mass_kg = bounds.motor_side_mass_kg.At(part(random)),
                      .skin_side_mass_kg = bounds.skin_side_mass_kg.At(part(random)),
                      .stiffness_n_per_m = bounds.stiffness_n_per_m.At(part(random)),
                      .damping_n_s_per_m = bounds.damping_n_s_per_m.At(part(random))},
          .contact_area_m2 = AreaAt(bounds.contact_area_m2, part(random))};
}

TEST(AdapterOptimum, OfTheSkinsRmsMeetsItsBars) {
  const AdapterOptimum optimum = FindAdapterOptimum(Objective::kSkinRms, ThesisProblem(), {});
  EXPECT_REL(optimum.value, 0.20188526e-3, 1e-7, "the bar");
  EXPECT_GE(optimum.upper_bound, optimum.value);
  EXPECT_LT(optimum.upper_bound / optimum.value - 1, 1e-5) << "the bar";
  EXPECT_LT(optimum.upper_bound / optimum.value - 1, 1.1e-9) << "the gap that was asked for";
  EXPECT_EQ(optimum.proof, Proof::kBranchAndBound);
}

TEST(AdapterOptimum, OfTheSkinsRmsIsThatOfThirtyDigits) {
  const AdapterOptimum optimum = FindAdapterOptimum(Objective::kSkinRms, ThesisProblem(), {});
  EXPECT_REL(optimum.value, tests::kRmsBest, 1e-14, kRounding);
  EXPECT_EQ(optimum.point.adapter.motor_side_mass_kg, tests::kRmsBestMa1);
  EXPECT_EQ(optimum.point.adapter.damping_n_s_per_m, tests::kRmsBestBa);
  EXPECT_EQ(optimum.point.contact_area_m2, tests::kRmsBestA);
  EXPECT_REL(optimum.point.adapter.skin_side_mass_kg, tests::kRmsBestMa2, 1e-6, kFlat);
  EXPECT_REL(optimum.point.adapter.stiffness_n_per_m, tests::kRmsBestKa, 1e-6, kFlat);
}

TEST(AdapterOptimum, OfTheStimulusLiesOnAStepOfNr) {
  const AdapterOptimum optimum = FindAdapterOptimum(Objective::kStimulus, ThesisProblem(), {});
  EXPECT_REL(optimum.value, 45 * tests::kStimulusBest, 1e-13, kRounding);
  EXPECT_REL(optimum.point.contact_area_m2, tests::kStimulusBestA, 1e-13, kRounding);
  EXPECT_EQ(optimum.point.adapter.stiffness_n_per_m, tests::kStimulusBestKa);
  EXPECT_REL(optimum.point.adapter.motor_side_mass_kg, tests::kStimulusBestMa1, 1e-5, kFlat);
  EXPECT_REL(optimum.point.adapter.skin_side_mass_kg, tests::kStimulusBestMa2, 1e-6, kFlat);
  EXPECT_LT(optimum.upper_bound / optimum.value - 1, 2.1e-9);
  EXPECT_EQ(optimum.proof, Proof::kBranchAndBound);
}

TEST(AdapterOptimum, OfTheStimulusSeesAStepAtTheAreasUpperEnd) {
  TuningProblem problem = ThesisProblem();
  problem.bounds.contact_area_m2.upper = tests::kStimulusBestA;
  const AdapterOptimum optimum = FindAdapterOptimum(Objective::kStimulus, problem, {});
  EXPECT_REL(optimum.value, 45 * tests::kStimulusBest, 1e-13, kRounding);
  EXPECT_EQ(optimum.point.contact_area_m2, tests::kStimulusBestA);
  EXPECT_GE(optimum.upper_bound, optimum.value);
}

TEST(AdapterOptimum, OfTheSkinsPowerIsThatOfThirtyDigits) {
  const AdapterOptimum optimum = FindAdapterOptimum(Objective::kSkinPower, ThesisProblem(), {});
  EXPECT_REL(optimum.value, tests::kPowerBest, 1e-13, kRounding);
  EXPECT_REL(optimum.point.contact_area_m2, tests::kPowerBestA, 1e-5, kFlat);
  EXPECT_REL(optimum.point.adapter.skin_side_mass_kg, tests::kPowerBestMa2, 1e-6, kFlat);
  EXPECT_LT(optimum.upper_bound / optimum.value - 1, 1.1e-9);
  EXPECT_EQ(optimum.proof, Proof::kBranchAndBound);
}

TEST(AdapterOptimum, OfTheRmsPerWattIsThatOfThirtyDigits) {
  const AdapterOptimum optimum = FindAdapterOptimum(Objective::kRmsPerWatt, ThesisProblem(), {});
  EXPECT_REL(optimum.value, tests::kPerWattBest, 1e-13, kRounding);
  EXPECT_REL(optimum.point.adapter.skin_side_mass_kg, tests::kPerWattBestMa2, 1e-6, kFlat);
  EXPECT_EQ(optimum.proof, Proof::kMatchedLoad);
  EXPECT_LT(optimum.upper_bound / optimum.value - 1, 0.015) << "as found; it is no tight bound";
  EXPECT_GT(optimum.upper_bound, optimum.value);
}

// also where a bound of Ma2 holds, the skin is another, the drive far from the resonance
TEST(AdapterOptimum, IsExceededByNoPointWithinTheBounds) {
  std::mt19937 random(11);
  for (int kind = 0; kind < 6; ++kind) {
    TuningProblem problem = ThesisProblem();
    if (kind == 1) problem.bounds.skin_side_mass_kg = {8e-3, 10e-3};
    if (kind == 2) problem.bounds.skin_side_mass_kg = {0.25e-3, 2e-3};
    if (kind == 3) problem.drive.frequency_hz = 60;
    if (kind == 4) problem.drive.frequency_hz = 700;
    if (kind == 5) problem.fixed_skin = Skin{.stiffness_n_per_m = 1500, .damping_n_s_per_m = 2};
    const MotorSource source = SourceOf(problem.actuator, problem.drive);
    for (const Objective objective : {Objective::kSkinRms, Objective::kSkinPower,
                                      Objective::kStimulus, Objective::kRmsPerWatt}) {
      const AdapterOptimum optimum = FindAdapterOptimum(objective, problem, {}, 1e-5);
      EXPECT_GE(optimum.upper_bound, optimum.value);
      if (objective == Objective::kSkinRms) {
        EXPECT_LT(optimum.upper_bound / optimum.value - 1, 1.01e-5) << kind;
      }
      for (int trial = 0; trial < 3000; ++trial) {
        const AdapterPoint point = Anywhere(problem.bounds, random);
        ASSERT_LE(ValueOf(objective, problem, source, {}, point), optimum.value * (1 + 1e-12))
            << kind << ' ' << Name(objective);
      }
    }
  }
}

// no skin within the variation moves less than the value says, and no adapter does better
TEST(AdapterOptimum, ForSkinsThatVaryIsThatOfTheHardest) {
  TuningProblem varied = ThesisProblem();
  varied.skin_variation = 0.3;
  const AdapterOptimum optimum = FindAdapterOptimum(Objective::kSkinRms, varied, {});
  EXPECT_LT(optimum.upper_bound / optimum.value - 1, 1.1e-9);
  EXPECT_EQ(optimum.proof, Proof::kBranchAndBound);
  const MotorSource source = SourceOf(varied.actuator, varied.drive);
  const AdapterPoint nominal = BestWithinTravel(Objective::kSkinRms, ThesisProblem(), {}).point;
  EXPECT_GT(optimum.value, ValueOf(Objective::kSkinRms, varied, source, {}, nominal));
  std::mt19937 random(2);
  std::uniform_real_distribution<double> part(-1, 1);
  const Skin skin = SkinOf(varied, optimum.point.contact_area_m2);
  for (int trial = 0; trial < 3000; ++trial) {
    const Skin other{.stiffness_n_per_m = skin.stiffness_n_per_m * (1 + 0.3 * part(random)),
                     .damping_n_s_per_m = skin.damping_n_s_per_m * (1 + 0.3 * part(random))};
    const AdapterMotion motion = MotionOf(source, optimum.point.adapter, other);
    ASSERT_GE(std::abs(motion.skin_m) / std::numbers::sqrt2, optimum.value * (1 - 1e-12));
    const AdapterPoint point = Anywhere(varied.bounds, random);
    ASSERT_LE(ValueOf(Objective::kSkinRms, varied, source, {}, point), optimum.value);
  }
  EXPECT_LE(BestOnGrid(varied, 9).score, optimum.value);
}

TEST(AdapterOptimum, GrowsWithItsBounds) {
  TuningProblem problem = ThesisProblem();
  double before = 0;
  for (const double wide : {0.1, 0.3, 0.6, 1.0}) {
    const AdapterBounds all = ThesisBounds();
    problem.bounds.stiffness_n_per_m = {all.stiffness_n_per_m.At(0.5 - wide / 2),
                                        all.stiffness_n_per_m.At(0.5 + wide / 2)};
    problem.bounds.damping_n_s_per_m.lower = 0.05 - 0.04 * wide;
    const double value = FindAdapterOptimum(Objective::kSkinRms, problem, {}).value;
    EXPECT_GE(value, before);
    before = value;
  }
}

TEST(AdapterOptimum, SaysWhatItHasWhenItMustStopEarly) {
  const AdapterOptimum optimum =
      FindAdapterOptimum(Objective::kSkinRms, ThesisProblem(), {}, 1e-9, 20);
  EXPECT_GE(optimum.boxes, 20U);
  EXPECT_LT(optimum.boxes, 23U);
  EXPECT_GT(optimum.upper_bound / optimum.value - 1, 1e-9);
}

// boxes that one stretch of areas had used up would leave the others unproved
TEST(AdapterOptimum, GivesEachStretchOfAreasItsBoxes) {
  TuningProblem held = ThesisProblem();
  held.bounds.skin_side_mass_kg = {2.5e-3, 2.5e-3};
  const AdapterOptimum optimum = FindAdapterOptimum(Objective::kStimulus, held, {}, 1e-9, 100);
  EXPECT_GT(optimum.boxes, 150U);
  EXPECT_GE(optimum.upper_bound, optimum.value);
}

// an undamped adapter takes the available power at any mass on the motor's side
TEST(MatchedLoad, IsReachedByALosslessAdapterAllAlongItsRidge) {
  TuningProblem problem = ThesisProblem();
  problem.bounds.damping_n_s_per_m = {0, 0};
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const double bound = MatchedLoadBound(Objective::kSkinRms, problem, source, {});
  for (const RidgePoint& point : RidgeOf(Objective::kSkinRms, problem, {}, 5)) {
    EXPECT_REL(point.value, bound, 1e-10, "equal by the closed form; the stated allowance");
    EXPECT_LE(point.value, bound);
  }
}

TEST(MatchedLoad, BoundsEveryObjectiveOfLossyAdapters) {
  const TuningProblem problem = ThesisProblem();
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  EXPECT_REL(MatchedLoadBound(Objective::kSkinRms, problem, source, {}), 0.20218208831753512e-3,
             1e-10, "the closed form in Python");
  for (const Objective objective :
       {Objective::kSkinRms, Objective::kSkinPower, Objective::kStimulus, Objective::kRmsPerWatt}) {
    EXPECT_GT(MatchedLoadBound(objective, problem, source, {}),
              FindAdapterOptimum(objective, problem, {}).value);
  }
}

TEST(AdapterRidge, IsFlatAndLeadsFromTheOptimumToTheGridsCorner) {
  const auto ridge = RidgeOf(Objective::kSkinRms, ThesisProblem(), {}, 6);
  ASSERT_EQ(ridge.size(), 6U);
  EXPECT_REL(ridge.front().value, tests::kRmsBest, 1e-13, kRounding);
  EXPECT_EQ(ridge.back().point.adapter.motor_side_mass_kg, 10e-3);
  for (std::size_t k = 1; k < ridge.size(); ++k) EXPECT_LT(ridge[k].value, ridge[k - 1].value);
  EXPECT_GT(ridge.back().value / ridge.front().value, 1 - 4e-4);
  EXPECT_GT(ridge.back().value, tests::kGridRmsM);
}

TEST(SpringCost, OfAWrongSpringIsMostlyPaidBackByTheSkinSidesMass) {
  const AdapterOptimum best = FindAdapterOptimum(Objective::kSkinRms, ThesisProblem(), {});
  for (const double factor : {0.95, 1.05}) {
    const SpringCost cost =
        CostOfSpring(Objective::kSkinRms, ThesisProblem(), {}, best.point, factor);
    EXPECT_LT(cost.as_built, 0.99 * best.value) << factor;
    EXPECT_GT(cost.rebalanced, 0.998 * best.value) << factor;
    EXPECT_LT(cost.rebalanced, best.value) << factor;
  }
  EXPECT_REL(CostOfSpring(Objective::kSkinRms, ThesisProblem(), {}, best.point, 1).as_built,
             best.value, 1e-14, "the same point");
}

// with everything else held, the best mass is that of the resonance, or its bound
TEST(SpringCost, IsThatOfTheWantedMass) {
  const TuningProblem problem = ThesisProblem();
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const AdapterPoint point{.adapter = {.motor_side_mass_kg = 1e-3,
                                       .skin_side_mass_kg = 4e-3,
                                       .stiffness_n_per_m = 8000,
                                       .damping_n_s_per_m = 0.03},
                           .contact_area_m2 = 10e-6};
  int at_a_bound = 0;
  for (const double factor : {0.3, 0.8, 1.25, 6.0}) {
    AdapterPoint other = point;
    other.adapter.stiffness_n_per_m *= factor;
    const SpringCost cost = CostOfSpring(Objective::kSkinRms, problem, {}, point, factor);
    EXPECT_EQ(cost.factor, factor);
    EXPECT_REL(cost.as_built, ValueOf(Objective::kSkinRms, problem, source, {}, other), 1e-14,
               "the same point");
    const double wanted_kg = WantedSkinSideMass(problem, source, other);
    other.adapter.skin_side_mass_kg = std::clamp(wanted_kg, 0.25e-3, 10e-3);
    at_a_bound += other.adapter.skin_side_mass_kg == wanted_kg ? 0 : 1;
    EXPECT_REL(cost.rebalanced, ValueOf(Objective::kSkinRms, problem, source, {}, other), 1e-12,
               "a maximum is flat");
    EXPECT_GE(cost.rebalanced, cost.as_built);
  }
  EXPECT_LT(at_a_bound, 4);
}

// each at its mass, evenly over the bounds, and the best there is with it
TEST(AdapterRidge, IsTheBestAtEachMass) {
  const TuningProblem problem = ThesisProblem();
  const auto ridge = RidgeOf(Objective::kSkinRms, problem, {}, 3);
  ASSERT_EQ(ridge.size(), 3U);
  const double masses_kg[] = {0.25e-3, 5.125e-3, 10e-3};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_DOUBLE_EQ(ridge[k].point.adapter.motor_side_mass_kg, masses_kg[k]);
    TuningProblem held = problem;
    held.bounds.motor_side_mass_kg = {masses_kg[k], masses_kg[k]};
    const AdapterOptimum optimum = FindAdapterOptimum(Objective::kSkinRms, held, {});
    EXPECT_REL(ridge[k].value, optimum.value, 1e-12, "a maximum is flat");
    EXPECT_LT(optimum.upper_bound / ridge[k].value - 1, 1.1e-9) << "proved";
  }
}

}  // namespace
}  // namespace haptometer::sim
