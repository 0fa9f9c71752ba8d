#include "sim/tuning/adapter_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <complex>
#include <numbers>
#include <vector>

#include "sim/linear/motor_source.h"
#include "sim/linear/steady_state.h"
#include "sim/skin/skin.h"
#include "tests/residual.h"
#include "tests/sim/tuning/adapter_reference.h"

namespace haptometer::sim {
namespace {

constexpr const char* kAllPoints = "NumPy at every point; 12 digits are kept";

// the value that a place on an axis of 20 stands for
double On(const Range& range, int place) {
  return EqualSteps(range, 20)[static_cast<std::size_t>(place)];
}

void ExpectPlaces(const AdapterPoint& point, const int (&places)[5]) {
  const AdapterBounds bounds = ThesisBounds();
  EXPECT_EQ(point.adapter.motor_side_mass_kg, On(bounds.motor_side_mass_kg, places[0]));
  EXPECT_EQ(point.adapter.skin_side_mass_kg, On(bounds.skin_side_mass_kg, places[1]));
  EXPECT_EQ(point.adapter.stiffness_n_per_m, On(bounds.stiffness_n_per_m, places[2]));
  EXPECT_EQ(point.adapter.damping_n_s_per_m, On(bounds.damping_n_s_per_m, places[3]));
  EXPECT_EQ(point.contact_area_m2, On(bounds.contact_area_m2, places[4]));
}

// every point of a grid, each by its own motion
double SlowBest(const TuningProblem& problem, std::size_t values,
                const std::vector<double>& weights) {
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const AdapterBounds& bounds = problem.bounds;
  const std::vector<double> areas = EqualSteps(bounds.contact_area_m2, values);
  double best = 0;
  for (const double Ma1 : EqualSteps(bounds.motor_side_mass_kg, values)) {
    for (const double Ma2 : EqualSteps(bounds.skin_side_mass_kg, values)) {
      for (const double Ka : EqualSteps(bounds.stiffness_n_per_m, values)) {
        for (const double Ba : EqualSteps(bounds.damping_n_s_per_m, values)) {
          for (std::size_t area = 0; area < values; ++area) {
            const AdapterMotion motion =
                MotionOf(source, {Ma1, Ma2, Ka, Ba}, SkinOf(problem, areas[area]));
            const double weight = weights.empty() ? 1 : weights[area];
            best = std::max(best, weight * std::abs(motion.skin_m) / std::numbers::sqrt2);
          }
        }
      }
    }
  }
  return best;
}

TEST(AdapterGrid, OfTheThesisHasTheBestOfEveryPoint) {
  const GridBest best = BestOnGrid(ThesisProblem(), 20);
  EXPECT_EQ(best.points, 3'200'000U);
  ExpectPlaces(best.point, tests::kGridPlaces);
  EXPECT_REL(best.skin_rms_m, tests::kGridRmsM, 2e-12, kAllPoints);
  EXPECT_EQ(best.score, best.skin_rms_m);
}

TEST(AdapterGrid, OfTheThesisIsTheNumberThatWasFoundBefore) {
  const GridBest best = BestOnGrid(ThesisProblem(), 20);
  EXPECT_ABS(best.skin_rms_m, 0.201586e-3, 0.5e-9, "the bar, six digits");
  EXPECT_ABS(best.point.adapter.skin_side_mass_kg, 5.3816e-3, 0.5e-7, "five digits");
  EXPECT_ABS(best.point.adapter.stiffness_n_per_m, 9894.7, 0.05, "five digits");
}

TEST(AdapterGrid, WeighsAreasByTheReceptorsThatTheyReach) {
  std::vector<double> weights;
  for (const double area_m2 : EqualSteps(ThesisBounds().contact_area_m2, 20)) {
    weights.push_back(StimulatedReceptors({}, ContactRadius(area_m2)));
  }
  const GridBest best = BestOnGrid(ThesisProblem(), 20, weights);
  ExpectPlaces(best.point, tests::kStimulusGridPlaces);
  EXPECT_REL(best.skin_rms_m, tests::kStimulusGridRmsM, 2e-12, kAllPoints);
  EXPECT_REL(best.score, 45 * tests::kStimulusGridRmsM, 2e-12, kAllPoints);
}

TEST(AdapterGrid, MissesNoPointOfOtherGrids) {
  TuningProblem problem = ThesisProblem();
  for (const double frequency_hz : {40.0, 225.0, 400.0}) {
    problem.drive.frequency_hz = frequency_hz;
    for (const std::size_t values : {1U, 2U, 5U, 7U}) {
      EXPECT_REL(BestOnGrid(problem, values).score, SlowBest(problem, values, {}), 1e-13,
                 "two orders of the same operations");
    }
  }
  const std::vector<double> weights{1, 3, 2, 5};
  EXPECT_REL(BestOnGrid(problem, 4, weights).score, SlowBest(problem, 4, weights), 1e-13,
             "two orders of the same operations");
}

TEST(AdapterGrid, TakesTheLeastOverTheSkinsThatVary) {
  TuningProblem problem = ThesisProblem();
  problem.skin_variation = 0.2;
  const GridBest best = BestOnGrid(problem, 12);
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  double least = 1;
  for (const Skin& skin : HardestSkins(problem, best.point.contact_area_m2)) {
    const AdapterMotion motion = MotionOf(source, best.point.adapter, skin);
    least = std::min(least, std::abs(motion.skin_m) / std::numbers::sqrt2);
  }
  EXPECT_REL(best.score, least, 1e-13, "two orders of the same operations");
  EXPECT_LT(best.score, BestOnGrid(ThesisProblem(), 12).score);
}

TEST(AdapterGrid, HoldsWhatHasEqualBounds) {
  TuningProblem problem = ThesisProblem();
  problem.bounds.skin_side_mass_kg = {4.35e-3, 4.35e-3};
  problem.bounds.stiffness_n_per_m = {8200, 8200};
  const GridBest best = BestOnGrid(problem, 6);
  EXPECT_EQ(best.point.adapter.skin_side_mass_kg, 4.35e-3);
  EXPECT_REL(best.score, SlowBest(problem, 6, {}), 1e-13, "two orders of the same operations");
}

TEST(AdapterGrid, WithoutAnyWeightHasNoMotion) {
  const GridBest best = BestOnGrid(ThesisProblem(), 3, {0, 0, 0});
  EXPECT_EQ(best.score, 0);
  EXPECT_EQ(best.skin_rms_m, 0);
  const GridBest half = BestOnGrid(ThesisProblem(), 3, {0.5, 0.5, 0.5});
  EXPECT_EQ(half.skin_rms_m, 2 * half.score) << "the motion itself";
}

// whatever rounding makes of lower + (upper - lower)
TEST(EqualSteps, BeginAndEndAtTheEndsOfTheirRange) {
  for (int k = 1; k <= 200; ++k) {
    const Range range{.lower = 0.003, .upper = 0.003 + k * 0.01};
    const std::vector<double> steps = EqualSteps(range, 5);
    EXPECT_EQ(steps.front(), range.lower);
    EXPECT_EQ(steps.back(), range.upper) << k;
    EXPECT_REL(steps[1], 0.003 + k * 0.0025, 1e-15, "rounding");
  }
  EXPECT_EQ(EqualSteps({.lower = 2, .upper = 3}, 1), std::vector<double>{2});
}

TEST(AdapterGrid, OfAFixedSkinHasFourAxes) {
  TuningProblem problem = ThesisProblem();
  problem.fixed_skin = Skin{.stiffness_n_per_m = 600, .damping_n_s_per_m = 0.75};
  const GridBest best = BestOnGrid(problem, 20);
  EXPECT_EQ(best.points, 160'000U);
  EXPECT_REL(best.skin_rms_m, tests::kGridRmsM, 2e-12, kAllPoints);
}

}  // namespace
}  // namespace haptometer::sim
