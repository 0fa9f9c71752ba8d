#include "sim/tuning/adapter_optimum.h"

#include <cmath>
#include <complex>
#include <limits>

#include "base/error.h"
#include "sim/tuning/adapter_grid.h"
#include "sim/tuning/travel_limit.h"
#include "sim/tuning/tuning_problem.h"

namespace haptometer::sim {
namespace {

// keeps the smaller of two bounds, with its proof
void Offer(AdapterOptimum& optimum, double bound, Proof proof) {
  if (!(bound < optimum.upper_bound)) return;
  optimum.upper_bound = bound;
  optimum.proof = proof;
}

// a bound below a point that was found is an error of the program
void CheckBound(Objective objective, const AdapterOptimum& optimum) {
  HAPTOMETER_CHECK(optimum.upper_bound >= optimum.value, "{}: bound {} by proof {} below {}",
                   Name(objective), optimum.upper_bound, static_cast<int>(optimum.proof),
                   optimum.value);
}

// whether the mover's travel (peak, m) is within the limit
bool KeepsToItsTravel(const TuningProblem& problem, const MotorSource& source,
                      const AdapterPoint& point) {
  const Skin skin = SkinOf(problem, point.contact_area_m2);
  return MoverTravel(source, MotionOf(source, point.adapter, skin).case_m) <= problem.mover_limit_m;
}

}  // namespace

AdapterOptimum FindAdapterOptimum(Objective objective, const TuningProblem& problem,
                                  const ReceptorField& receptors, double relative_gap,
                                  std::size_t most_boxes) {
  const bool limited = std::isfinite(problem.mover_limit_m);
  const bool of_motion = objective == Objective::kSkinRms || objective == Objective::kStimulus;
  HAPTOMETER_CHECK(!Fault(problem) && relative_gap > 0, "gap {}", relative_gap);
  HAPTOMETER_CHECK(problem.skin_variation == 0 || (of_motion && !limited),
                   "{} of skins that vary, limit {}", Name(objective), problem.mover_limit_m);
  HAPTOMETER_CHECK(!limited || objective != Objective::kRmsPerWatt, "{} with limited travel",
                   Name(objective));
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  // first without the limit: if that optimum keeps to it, it is the answer with the tighter proof
  TuningProblem unlimited = problem;
  unlimited.mover_limit_m = std::numeric_limits<double>::infinity();
  LimitedBest best = BestWithinTravel(objective, unlimited, receptors);
  const bool keeps = !limited || KeepsToItsTravel(problem, source, best.point);
  if (!keeps) best = BestWithinTravel(objective, problem, receptors);
  AdapterOptimum optimum{.point = best.point,
                         .value = best.value,
                         .upper_bound = MatchedLoadBound(objective, problem, source, receptors)};
  if (limited) {
    Offer(optimum, LimitedTravelBound(objective, problem, source, receptors),
          Proof::kLimitedTravel);
  }
  // no adapter found within the limit: nothing to prove
  if (best.value > 0) {
    const TravelBound proved = BoundWithinTravel(objective, keeps ? unlimited : problem, receptors,
                                                 relative_gap, most_boxes, best);
    optimum.boxes = proved.boxes;
    Offer(optimum, proved.value, Proof::kBranchAndBound);
  }
  // the proof may have come upon a better one
  optimum.point = best.point;
  optimum.value = best.value;
  CheckBound(objective, optimum);
  return optimum;
}

std::vector<RidgePoint> RidgeOf(Objective objective, const TuningProblem& problem,
                                const ReceptorField& receptors, std::size_t values) {
  HAPTOMETER_CHECK(values >= 2, "{} values", values);
  std::vector<RidgePoint> ridge;
  ridge.reserve(values);
  for (const double mass_kg : EqualSteps(problem.bounds.motor_side_mass_kg, values)) {
    // Ma1 is fixed at each value, all other numbers are free
    TuningProblem fixed = problem;
    fixed.bounds.motor_side_mass_kg = {mass_kg, mass_kg};
    const LimitedBest best = BestWithinTravel(objective, fixed, receptors);
    if (best.value > 0) ridge.push_back({.point = best.point, .value = best.value});
  }
  return ridge;
}

SpringCost CostOfSpring(Objective objective, const TuningProblem& problem,
                        const ReceptorField& receptors, const AdapterPoint& point, double factor) {
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  AdapterPoint other = point;
  other.adapter.stiffness_n_per_m *= factor;
  SpringCost cost{.factor = factor,
                  .as_built = ValueOf(objective, problem, source, receptors, other)};

  // everything but Ma2 held where it is
  TuningProblem held = problem;
  const auto hold = [](double value) { return Range{.lower = value, .upper = value}; };
  held.bounds.motor_side_mass_kg = hold(other.adapter.motor_side_mass_kg);
  held.bounds.stiffness_n_per_m = hold(other.adapter.stiffness_n_per_m);
  held.bounds.damping_n_s_per_m = hold(other.adapter.damping_n_s_per_m);
  held.bounds.contact_area_m2 = hold(other.contact_area_m2);
  cost.rebalanced = BestWithinTravel(objective, held, receptors).value;
  return cost;
}

}  // namespace haptometer::sim
