#include "sim/tuning/travel_limit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "sim/steady_state.h"
#include "sim/tuning/adapter_optimum.h"
#include "tests/residual.h"
#include "tests/sim/tuning/adapter_reference.h"

namespace haptometer::sim {
namespace {

TuningProblem Limited(double mover_limit_m) {
  TuningProblem problem = ThesisProblem();
  problem.mover_limit_m = mover_limit_m;
  return problem;
}

// by the seven states
double TravelOf(const TuningProblem& problem, const AdapterPoint& point) {
  const Skin skin = SkinOf(problem, point.contact_area_m2);
  return SolveSteadyState(AssembleModel(problem.actuator, point.adapter, skin), problem.drive, skin)
      .mover_peak_m;
}

AdapterPoint Anywhere(const AdapterBounds& bounds, std::mt19937& random) {
  std::uniform_real_distribution<double> part(0, 1);
  return {.adapter = {.motor_side_mass_kg = bounds.motor_side_mass_kg.At(part(random)),
                      .skin_side_mass_kg = bounds.skin_side_mass_kg.At(part(random)),
                      .stiffness_n_per_m = bounds.stiffness_n_per_m.At(part(random)),
                      .damping_n_s_per_m = bounds.damping_n_s_per_m.At(part(random))},
          .contact_area_m2 = AreaAt(bounds.contact_area_m2, part(random))};
}

TEST(MoverTravel, IsThatOfTheSevenStates) {
  const TuningProblem problem = ThesisProblem();
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  std::mt19937 random(4);
  for (int trial = 0; trial < 300; ++trial) {
    const AdapterPoint point = Anywhere(problem.bounds, random);
    const AdapterMotion motion =
        MotionOf(source, point.adapter, SkinOf(problem, point.contact_area_m2));
    EXPECT_REL(MoverTravel(source, motion.case_m), TravelOf(problem, point), 1e-11,
               "the source's allowance");
  }
}

// against a fine grid of masses, each solved by the seven states
TEST(TravelLimit, TakesTheNearestMassThatKeepsToIt) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> limits(0.05e-3, 1e-3), masses(-2e-3, 14e-3);
  int limited = 0, none = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const TuningProblem problem = Limited(limits(random));
    const MotorSource source = SourceOf(problem.actuator, problem.drive);
    AdapterPoint point = Anywhere(problem.bounds, random);
    const double wanted_kg = masses(random);
    const auto found = NearestWithinTravel(problem, source, point, wanted_kg);
    if (found) {
      point.adapter.skin_side_mass_kg = *found;
      EXPECT_LE(TravelOf(problem, point), problem.mover_limit_m * (1 + 1e-9));
      EXPECT_GE(*found, problem.bounds.skin_side_mass_kg.lower);
      EXPECT_LE(*found, problem.bounds.skin_side_mass_kg.upper);
      limited += std::abs(TravelOf(problem, point) / problem.mover_limit_m - 1) < 1e-9 ? 1 : 0;
    } else {
      ++none;
    }
    const double distance_kg = found ? std::abs(*found - wanted_kg) : HUGE_VAL;
    constexpr int kMasses = 200;
    for (int k = 0; k <= kMasses; ++k) {
      const double mass_kg = problem.bounds.skin_side_mass_kg.At(k / double{kMasses});
      point.adapter.skin_side_mass_kg = mass_kg;
      if (std::abs(mass_kg - wanted_kg) >= distance_kg * (1 - 1e-9)) continue;
      ASSERT_GT(TravelOf(problem, point), problem.mover_limit_m * (1 - 1e-9)) << trial << ' ' << k;
    }
  }
  EXPECT_GT(limited, 5) << "cases in which the limit holds";
  EXPECT_GT(none, 5) << "cases without any mass";
}

TEST(TravelLimit, OptimumIsThatOfThirtyDigits) {
  const TuningProblem problem = Limited(0.4e-3);
  const AdapterOptimum optimum = FindAdapterOptimum(Objective::kSkinRms, problem, {});
  EXPECT_REL(optimum.value, tests::kLimitedBest, 1e-9, "a bent ridge, climbed without slopes");
  EXPECT_REL(optimum.point.adapter.stiffness_n_per_m, tests::kLimitedBestKa, 1e-4, "flat");
  EXPECT_REL(optimum.point.adapter.skin_side_mass_kg, tests::kLimitedBestMa2, 1e-4, "flat");
  EXPECT_LE(TravelOf(problem, optimum.point), 0.4e-3 * (1 + 1e-9));
  EXPECT_EQ(optimum.proof, Proof::kLimitedTravel);
  EXPECT_GT(optimum.upper_bound, optimum.value);
  EXPECT_LT(optimum.upper_bound / optimum.value, 1.01) << "as found; it is no tight bound";
}

TEST(TravelLimit, OptimumIsExceededByNoPointThatKeepsToIt) {
  std::mt19937 random(6);
  const TuningProblem problem = Limited(0.4e-3);
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  int kept = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const AdapterPoint point = Anywhere(problem.bounds, random);
    const AdapterMotion motion =
        MotionOf(source, point.adapter, SkinOf(problem, point.contact_area_m2));
    if (MoverTravel(source, motion.case_m) > problem.mover_limit_m) continue;
    ++kept;
    ASSERT_LE(ValueOf(Objective::kSkinRms, problem, source, {}, point), tests::kLimitedBest);
  }
  EXPECT_GT(kept, 1000);
}

TEST(TravelLimit, ThatIsNotReachedChangesNothing) {
  const AdapterOptimum free = FindAdapterOptimum(Objective::kSkinRms, ThesisProblem(), {});
  const AdapterOptimum wide = FindAdapterOptimum(Objective::kSkinRms, Limited(1e-3), {});
  EXPECT_EQ(wide.value, free.value);
  EXPECT_EQ(wide.upper_bound, free.upper_bound);
  EXPECT_EQ(wide.proof, Proof::kBranchAndBound);
  EXPECT_EQ(FindAdapterOptimum(Objective::kSkinRms, Limited(1e-6), {}).value, 0) << "none";
}

}  // namespace
}  // namespace haptometer::sim
