// The upper bound of tune over random actuators, drives, bounds, skins and limits.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "sim/tuning/adapter_optimum.h"
#include "tests/repetitions.h"

namespace haptometer::sim {
namespace {

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double Part() { return part_(random_); }
  // evenly over the logarithm
  double Scale(double least, double most) { return least * std::pow(most / least, Part()); }
  bool OneIn(double number) { return Part() * number < 1; }
  // a part of the range, all of it, or one value
  Range Within(const Range& all) {
    if (OneIn(3)) return all;
    double lower = Part(), upper = Part();
    if (lower > upper) std::swap(lower, upper);
    if (OneIn(3)) upper = lower;
    return {.lower = all.At(lower), .upper = all.At(upper)};
  }

 private:
  std::mt19937 random_;
  std::uniform_real_distribution<double> part_{0, 1};
};

struct AskedProblem {
  Objective objective = Objective::kSkinRms;
  TuningProblem problem;
};

AskedProblem AnyProblem(Draw& draw) {
  AskedProblem asked{.objective = draw.OneIn(3)   ? Objective::kSkinPower
                                  : draw.OneIn(3) ? Objective::kStimulus
                                                  : Objective::kSkinRms,
                     .problem = ThesisProblem()};
  TuningProblem& problem = asked.problem;
  Actuator& actuator = problem.actuator;
  actuator.moving_mass_kg *= draw.Scale(0.2, 5);
  actuator.case_mass_kg *= draw.Scale(0.2, 5);
  actuator.stiffness_n_per_m *= draw.Scale(0.1, 10);
  actuator.damping_n_s_per_m *= draw.Scale(0.05, 20);
  actuator.force_constant_n_per_a *= draw.Scale(0.2, 5);
  problem.drive.frequency_hz = draw.Scale(20, 1000);
  AdapterBounds& bounds = problem.bounds;
  bounds.motor_side_mass_kg = draw.Within(bounds.motor_side_mass_kg);
  bounds.skin_side_mass_kg = draw.Within(bounds.skin_side_mass_kg);
  bounds.stiffness_n_per_m = draw.Within(bounds.stiffness_n_per_m);
  bounds.damping_n_s_per_m = draw.OneIn(4) ? Range{} : draw.Within(bounds.damping_n_s_per_m);
  bounds.contact_area_m2 = draw.Within(bounds.contact_area_m2);
  if (asked.objective != Objective::kStimulus && draw.OneIn(4)) {
    problem.fixed_skin =
        Skin{.stiffness_n_per_m = draw.Scale(100, 5000), .damping_n_s_per_m = draw.Scale(0.1, 10)};
  }
  if (draw.OneIn(3)) return asked;
  // below and a little above what the best one travels
  const MotorSource source = SourceOf(actuator, problem.drive);
  const AdapterPoint best = BestAdapter(asked.objective, problem, {});
  const Skin skin = SkinOf(problem, best.contact_area_m2);
  problem.mover_limit_m =
      draw.Scale(0.1, 1.2) * MoverTravel(source, MotionOf(source, best.adapter, skin).case_m);
  return asked;
}

AdapterPoint Anywhere(const AdapterBounds& bounds, Draw& draw) {
  // bounds often hold the best
  const auto at = [&](const Range& range) {
    return range.At(std::clamp(1.6 * draw.Part() - 0.3, 0.0, 1.0));
  };
  return {.adapter = {.motor_side_mass_kg = at(bounds.motor_side_mass_kg),
                      .skin_side_mass_kg = at(bounds.skin_side_mass_kg),
                      .stiffness_n_per_m = at(bounds.stiffness_n_per_m),
                      .damping_n_s_per_m = at(bounds.damping_n_s_per_m)},
          .contact_area_m2 = AreaAt(bounds.contact_area_m2, draw.Part())};
}

// An optimum above its bound would fail FindAdapterOptimum()'s own check. No adapter that keeps to
// the limit comes above the bound; few boxes, so that all kinds of bound are told.
TEST(AdapterOptimum, OfRandomProblemsIsBounded) {
  const int problems = tests::Repetitions(24);
  int found = 0, kept = 0;
  for (int seed = 0; seed < problems; ++seed) {
    Draw draw(static_cast<unsigned>(seed));
    const auto [objective, problem] = AnyProblem(draw);
    const std::size_t most_boxes = draw.OneIn(2) ? 30 : 1000;
    const AdapterOptimum optimum = FindAdapterOptimum(objective, problem, {}, 1e-9, most_boxes);
    if (!(optimum.value > 0)) continue;
    ++found;
    EXPECT_GE(optimum.upper_bound, optimum.value) << "seed " << seed;
    const MotorSource source = SourceOf(problem.actuator, problem.drive);
    for (int trial = 0; trial < 3000; ++trial) {
      const AdapterPoint point = Anywhere(problem.bounds, draw);
      const Skin skin = SkinOf(problem, point.contact_area_m2);
      const AdapterMotion motion = MotionOf(source, point.adapter, skin);
      if (MoverTravel(source, motion.case_m) > problem.mover_limit_m) continue;
      ++kept;
      ASSERT_LE(ValueOf(objective, problem, source, {}, point), optimum.upper_bound)
          << "seed " << seed;
    }
  }
  EXPECT_GT(found, problems / 3);
  EXPECT_GT(kept, 1000);
}

}  // namespace
}  // namespace haptometer::sim
