#include "sim/tuning/adapter_optimum.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <utility>

#include "base/error.h"
#include "sim/tuning/adapter_cost.h"
#include "sim/tuning/adapter_grid.h"
#include "sim/tuning/search.h"
#include "sim/tuning/travel_limit.h"
#include "sim/tuning/tuning_problem.h"

namespace haptometer::sim {
namespace {

// sets Ma2 to that of the skin's largest motion within its bounds
void ServeBest(const TuningProblem& problem, const MotorSource& source, AdapterPoint& point) {
  const Range& mass_kg = problem.bounds.skin_side_mass_kg;
  point.adapter.skin_side_mass_kg =
      std::clamp(WantedSkinSideMass(problem, source, point), mass_kg.lower, mass_kg.upper);
}

// Ma1, Ka, Ba and area at a place of the cube, with the Ma2 of the skin's largest motion
AdapterPoint PointAt(const TuningProblem& problem, const MotorSource& source,
                     const CubePlace& place) {
  AdapterPoint point = PointOf(problem.bounds, place);
  ServeBest(problem, source, point);
  return point;
}

// for skins that vary: no slopes, as the least motion has a kink where the hardest skin changes
RidgePoint BestOfPiece(const AreaPiece& piece, const ReceptorField& receptors) {
  const MotorSource source = SourceOf(piece.problem.actuator, piece.problem.drive);
  const auto pointed = [&](const std::vector<double>& parts) {
    return PointAt(piece.problem, source, {parts[0], parts[1], parts[2], parts[3], 0});
  };
  const auto value = [&](const std::vector<double>& parts) {
    return ValueOf(piece.objective, piece.problem, source, receptors, pointed(parts));
  };
  CubePoint start{.place = {}, .value = -1};
  // begins at the best place of lattice and ridge
  for (const CubePlace& place : StartPlaces(piece.problem, source)) {
    CubePoint tried{.place = {place[0], place[1], place[2], place[3]}};
    tried.value = value(tried.place);
    if (tried.value > start.value) start = std::move(tried);
  }
  const CubePoint best = ClimbWithinCube(value, start.place);
  return {.point = pointed(best.place), .value = piece.weight * best.value};
}

RidgePoint Best(Objective objective, const TuningProblem& problem, const ReceptorField& receptors) {
  // Newton's steps, where all slopes are known
  if (problem.skin_variation == 0) {
    const LimitedBest limited = BestWithinTravel(objective, problem, receptors);
    return {.point = limited.point, .value = limited.value};
  }
  RidgePoint best;
  for (const AreaPiece& piece : PiecesOf(objective, problem, receptors)) {
    const RidgePoint found = BestOfPiece(piece, receptors);
    if (found.value > best.value) best = found;
  }
  return best;
}

}  // namespace

AdapterPoint BestAdapter(Objective objective, const TuningProblem& problem,
                         const ReceptorField& receptors) {
  return Best(objective, problem, receptors).point;
}

namespace {

// keeps the smaller of two bounds, with its proof
void Offer(AdapterOptimum& optimum, double bound, Proof proof) {
  if (!(bound < optimum.upper_bound)) return;
  optimum.upper_bound = bound;
  optimum.proof = proof;
}

// Offers the adapter in the box's middle, and where it is better also the summit above it.
void TryMiddle(const AreaPiece& piece, const MotorSource& source, const ReceptorField& receptors,
               const AdapterBox& box, AdapterOptimum& optimum) {
  const AdapterBounds& bounds = piece.problem.bounds;
  const auto offer = [&](const AdapterPoint& point) {
    const double value =
        piece.weight * ValueOf(piece.objective, piece.problem, source, receptors, point);
    if (!(value > optimum.value)) return false;
    optimum.point = point;
    optimum.value = value;
    return true;
  };
  AdapterPoint middle{
      .adapter = {.motor_side_mass_kg = bounds.motor_side_mass_kg.At(box[0].middle()),
                  .stiffness_n_per_m = bounds.stiffness_n_per_m.At(box[1].middle()),
                  .damping_n_s_per_m = bounds.damping_n_s_per_m.At(box[2].middle())},
      .contact_area_m2 = AreaAt(bounds.contact_area_m2, box[3].middle())};
  ServeBest(piece.problem, source, middle);
  if (!offer(middle) || piece.problem.skin_variation > 0) return;
  const LimitedClimb climb(piece.objective, piece.problem, source, receptors);
  offer(PointOf(bounds, climb.From(PlaceOf(bounds, middle)).place));
}

// The largest of the bounds of the pieces of areas; none where there is no proof by boxes.
void ProveUnlimited(Objective objective, const TuningProblem& problem, const MotorSource& source,
                    const ReceptorField& receptors, double relative_gap, std::size_t most_boxes,
                    AdapterOptimum& optimum) {
  const bool steps = HasSteps(objective, receptors);
  const bool provable = objective == Objective::kSkinRms || objective == Objective::kSkinPower;
  if (!provable && !steps) return;
  double bound = 0;
  for (const AreaPiece& piece : PiecesOf(objective, problem, receptors)) {
    if (!(piece.weight > 0)) continue;
    // below this cost an adapter would exceed the value by more than the gap
    const double enough = CostOfValue(piece, source, optimum.value * (1 + relative_gap));
    const AdapterCost cost(piece.problem, source, piece.objective == Objective::kSkinPower);
    const LeastOfBoxes least =
        LeastCost([&](const AdapterBox& box) { return cost.Over(box); }, enough, most_boxes);
    optimum.boxes += least.boxes;
    TryMiddle(piece, source, receptors, least.reached, optimum);
    bound = std::max(bound, ValueOfCost(piece, source, least.cost));
  }
  // allowance for the rounding of the source, squared in a power
  const double squares = objective == Objective::kSkinPower ? 2 : 1;  // of an RMS
  const double allowed = 1 + squares * source.rounding_allowance + (steps ? kStepAllowance : 0);
  Offer(optimum, bound * allowed, Proof::kBranchAndBound);
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
  const RidgePoint best = Best(objective, unlimited, receptors);
  AdapterOptimum optimum{.point = best.point,
                         .value = best.value,
                         .upper_bound = MatchedLoadBound(objective, problem, source, receptors)};
  if (limited) {
    Offer(optimum, LimitedTravelBound(objective, problem, source, receptors),
          Proof::kLimitedTravel);
  }
  if (!limited || KeepsToItsTravel(problem, source, best.point)) {
    ProveUnlimited(objective, unlimited, source, receptors, relative_gap, most_boxes, optimum);
    CheckBound(objective, optimum);
    return optimum;
  }
  const LimitedBest within = BestWithinTravel(objective, problem, receptors);
  optimum.point = within.point;
  optimum.value = within.value;
  // no adapter found within the limit
  if (!(within.value > 0)) return optimum;
  const TravelBound proved =
      BoundWithinTravel(objective, problem, receptors, within, relative_gap, most_boxes);
  optimum.boxes = proved.boxes;
  Offer(optimum, proved.value, Proof::kBranchAndBound);
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
    const RidgePoint best = Best(objective, fixed, receptors);
    if (best.value > 0) ridge.push_back(best);
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
  cost.rebalanced = Best(objective, held, receptors).value;
  return cost;
}

}  // namespace haptometer::sim
