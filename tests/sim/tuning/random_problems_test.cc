// The optimum and the upper bound of tune over random actuators, drives, bounds, skins and limits.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>

#include "sim/tuning/adapter_optimum.h"
#include "sim/tuning/travel_limit.h"
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
  // from one to eight decades
  Range Decades(double least, double most) {
    double lower = Scale(least, most), upper = Scale(least, most);
    if (lower > upper) std::swap(lower, upper);
    return {.lower = lower, .upper = upper};
  }
  double Normal() { return normal_(random_); }
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
  std::normal_distribution<double> normal_{};
};

struct AskedProblem {
  Objective objective = Objective::kSkinRms;
  TuningProblem problem;
};

AskedProblem AnyProblem(Draw& draw) {
  AskedProblem asked{.objective = draw.OneIn(4)   ? Objective::kRmsPerWatt
                                  : draw.OneIn(3) ? Objective::kSkinPower
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
  if (draw.OneIn(4)) {
    bounds.motor_side_mass_kg = draw.Decades(1e-6, 1);
    bounds.skin_side_mass_kg = draw.Decades(1e-6, 1);
  }
  bounds.motor_side_mass_kg = draw.Within(bounds.motor_side_mass_kg);
  bounds.skin_side_mass_kg = draw.Within(bounds.skin_side_mass_kg);
  bounds.stiffness_n_per_m =
      draw.OneIn(2) ? draw.Decades(1, 1e8) : draw.Within(bounds.stiffness_n_per_m);
  bounds.damping_n_s_per_m = draw.OneIn(4)   ? Range{}
                             : draw.OneIn(2) ? draw.Decades(1e-4, 1e3)
                                             : draw.Within(bounds.damping_n_s_per_m);
  bounds.contact_area_m2 = draw.Within(bounds.contact_area_m2);
  if (asked.objective != Objective::kStimulus && draw.OneIn(4)) {
    problem.fixed_skin =
        Skin{.stiffness_n_per_m = draw.Scale(100, 5000), .damping_n_s_per_m = draw.Scale(0.1, 10)};
  }
  if (asked.objective == Objective::kRmsPerWatt || draw.OneIn(3)) return asked;
  // below and a little above what the best one travels
  const MotorSource source = SourceOf(actuator, problem.drive);
  const AdapterPoint best = BestWithinTravel(asked.objective, problem, {}).point;
  const Skin skin = SkinOf(problem, best.contact_area_m2);
  problem.mover_limit_m =
      draw.Scale(0.1, 1.2) * MoverTravel(source, MotionOf(source, best.adapter, skin).case_m);
  return asked;
}

// Each number as its part of the way, evenly over its logarithm where its lower end is above 0.
using Parts = std::array<double, 5>;

double NumberAt(const Range& range, double part) {
  if (range.lower == range.upper || part <= 0) return range.lower;
  if (part >= 1) return range.upper;
  return range.lower > 0 ? range.lower * std::pow(range.upper / range.lower, part)
                         : range.upper * part;
}

AdapterPoint AdapterAt(const AdapterBounds& bounds, const Parts& parts) {
  return {.adapter = {.motor_side_mass_kg = NumberAt(bounds.motor_side_mass_kg, parts[0]),
                      .skin_side_mass_kg = NumberAt(bounds.skin_side_mass_kg, parts[1]),
                      .stiffness_n_per_m = NumberAt(bounds.stiffness_n_per_m, parts[2]),
                      .damping_n_s_per_m = NumberAt(bounds.damping_n_s_per_m, parts[3])},
          .contact_area_m2 = NumberAt(bounds.contact_area_m2, parts[4])};
}

// The best of random adapters that keep to the limit, and of ever smaller random steps from it:
// MotionOf() alone is shared with what is tested.
class RandomSearch {
 public:
  RandomSearch(const AskedProblem& asked, Draw& draw)
      : asked_(asked),
        draw_(draw),
        source_(SourceOf(asked.problem.actuator, asked.problem.drive)) {}

  double Best(int trials, int steps) {
    for (int trial = 0; trial < trials; ++trial) {
      Parts parts;
      // bounds often hold the best
      for (double& part : parts) part = std::clamp(1.6 * draw_.Part() - 0.3, 0.0, 1.0);
      Try(parts);
    }
    for (int step = 0; step < steps; ++step) {
      Parts parts = best_parts_;
      const double size = draw_.Scale(1e-6, 0.3);
      for (double& part : parts) {
        if (draw_.OneIn(2)) part = std::clamp(part + size * draw_.Normal(), 0.0, 1.0);
      }
      Try(parts);
    }
    return best_;
  }
  [[nodiscard]] int kept() const { return kept_; }

 private:
  void Try(const Parts& parts) {
    const AdapterPoint point = AdapterAt(asked_.problem.bounds, parts);
    const Skin skin = SkinOf(asked_.problem, point.contact_area_m2);
    const AdapterMotion motion = MotionOf(source_, point.adapter, skin);
    if (MoverTravel(source_, motion.case_m) > asked_.problem.mover_limit_m) return;
    ++kept_;
    const double value = ValueOf(asked_.objective, asked_.problem, source_, {}, point);
    if (!(value > best_)) return;
    best_ = value;
    best_parts_ = parts;
  }

  const AskedProblem& asked_;
  Draw& draw_;
  MotorSource source_;
  Parts best_parts_{};
  double best_ = 0;
  int kept_ = 0;
};

// No adapter that random search finds comes above the bound, nor above the optimum by more than the
// 1e-9 to which SciPy's optima are met; few boxes, so that all kinds of bound are told. An optimum
// above its bound would fail FindAdapterOptimum()'s own check.
TEST(AdapterOptimum, OfRandomProblemsIsNotExceeded) {
  const int problems = tests::Repetitions(40);
  int found = 0, kept = 0;
  for (int seed = 0; seed < problems; ++seed) {
    Draw draw(static_cast<unsigned>(seed));
    const AskedProblem asked = AnyProblem(draw);
    const std::size_t most_boxes = draw.OneIn(2) ? 30 : 1000;
    const AdapterOptimum optimum =
        FindAdapterOptimum(asked.objective, asked.problem, {}, 1e-9, most_boxes);
    RandomSearch search(asked, draw);
    const double best = search.Best(3000, 3000);
    EXPECT_LE(best, optimum.value * (1 + 1e-9)) << "seed " << seed << ", " << Name(asked.objective)
                                                << ", exceeded by " << best / optimum.value - 1;
    EXPECT_LE(best, optimum.upper_bound) << "seed " << seed;
    found += optimum.value > 0 ? 1 : 0;
    kept += search.kept();
  }
  EXPECT_GT(found, problems / 3);
  EXPECT_GT(kept, 1000);
}

// The optimum lies within all of these ranges, so that it is the same.
TEST(AdapterOptimum, IsThatOfNarrowRangesInWideOnes) {
  for (const Objective objective :
       {Objective::kSkinRms, Objective::kStimulus, Objective::kSkinPower, Objective::kRmsPerWatt}) {
    const AdapterOptimum narrow = FindAdapterOptimum(objective, ThesisProblem(), {}, 1e-6);
    for (const Range& wide : {Range{100, 1e7}, Range{500, 1e7}, Range{1, 1e8}}) {
      TuningProblem problem = ThesisProblem();
      problem.bounds.stiffness_n_per_m = wide;
      const AdapterOptimum optimum = FindAdapterOptimum(objective, problem, {}, 1e-6);
      EXPECT_GE(optimum.value, narrow.value * (1 - 1e-9))
          << Name(objective) << " to " << wide.upper << " N/m";
    }
  }
}

}  // namespace
}  // namespace haptometer::sim
