#include "sim/tuning/adapter_optimum.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <optional>
#include <queue>

#include "base/check.h"
#include "sim/tuning/adapter_box.h"
#include "sim/tuning/adapter_grid.h"
#include "sim/tuning/compass_search.h"
#include "sim/tuning/travel_limit.h"

namespace haptometer::sim {

namespace {

// a stretch of areas on which the weight of the RMS is constant
struct Piece {
  TuningProblem problem;  // with the stretch as its areas
  Objective objective = Objective::kSkinRms;
  double weight = 1;
};

// a stretch's end may be rounded to the other side of a step, which moves an RMS by less than this
constexpr double kStepAllowance = 1e-9;

bool HasSteps(Objective objective, const ReceptorField& receptors) {
  return objective == Objective::kStimulus && receptors.edge_width_m == 0;
}

// the areas at which Nr steps up, with both ends of the bounds around them
std::vector<double> StepAreas(const Range& area_m2, const ReceptorField& receptors) {
  std::vector<double> ends{area_m2.lower};
  const std::vector<double> radii = SteppingRadii(receptors);
  ends.reserve(radii.size() + 2);
  for (const double radius_m : radii) {
    const double step_m2 = ContactArea(radius_m);
    if (step_m2 > area_m2.lower && step_m2 < area_m2.upper) ends.push_back(step_m2);
  }
  ends.push_back(area_m2.upper);
  return ends;
}

std::vector<Piece> PiecesOf(Objective objective, const TuningProblem& problem,
                            const ReceptorField& receptors) {
  if (!HasSteps(objective, receptors)) return {{.problem = problem, .objective = objective}};
  const std::vector<double> ends = StepAreas(problem.bounds.contact_area_m2, receptors);
  std::vector<Piece> pieces;
  pieces.reserve(ends.size());
  for (std::size_t k = 0; k < ends.size(); ++k) {
    // the upper end is a stretch of its own: it may lie on a step
    Piece piece{.problem = problem};
    piece.problem.bounds.contact_area_m2 = {ends[k], ends[std::min(k + 1, ends.size() - 1)]};
    piece.weight = StimulatedReceptors(receptors, ContactRadius(ends[k]));
    pieces.push_back(piece);
  }
  return pieces;
}

// Ma2 where it serves |Xs| best: the nearest to (Ks + Re Z) / w^2 that may be
std::optional<double> BestSkinSideMass(const TuningProblem& problem, const MotorSource& source,
                                       const AdapterPoint& point) {
  const double w = source.omega_rad_per_s;
  const double Mc1 = source.case_mass_kg + point.adapter.motor_side_mass_kg;
  const std::complex<double> D1 = source.stiffness_n_per_m - Mc1 * w * w;
  const std::complex<double> ka(point.adapter.stiffness_n_per_m,
                                point.adapter.damping_n_s_per_m * w);
  const std::complex<double> Z = D1 * ka / (D1 + ka);
  const double Ks = SkinOf(problem, point.contact_area_m2).stiffness_n_per_m;
  const Range& mass_kg = problem.bounds.skin_side_mass_kg;
  const double wanted_kg = (Ks + Z.real()) / (w * w);
  if (std::isinf(problem.mover_limit_m)) return std::clamp(wanted_kg, mass_kg.lower, mass_kg.upper);
  return NearestWithinTravel(problem, source, point, wanted_kg);
}

// the point at a place of the unit cube: Ma1, Ka, Ba, area and, where it is not eliminated, Ma2;
// nothing where no Ma2 keeps the mover within its limit
std::optional<AdapterPoint> PointAt(const TuningProblem& problem, const MotorSource& source,
                                    const std::vector<double>& place) {
  const AdapterBounds& bounds = problem.bounds;
  AdapterPoint point{.adapter = {.motor_side_mass_kg = bounds.motor_side_mass_kg.At(place[0]),
                                 .stiffness_n_per_m = bounds.stiffness_n_per_m.At(place[1]),
                                 .damping_n_s_per_m = bounds.damping_n_s_per_m.At(place[2])},
                     .contact_area_m2 = AreaAt(bounds.contact_area_m2, place[3])};
  const std::optional<double> mass_kg = place.size() > kBoxAxes
                                            ? bounds.skin_side_mass_kg.At(place[kBoxAxes])
                                            : BestSkinSideMass(problem, source, point);
  if (!mass_kg) return std::nullopt;
  point.adapter.skin_side_mass_kg = *mass_kg;
  return point;
}

bool IsPoint(const Range& range) { return range.lower == range.upper; }

RidgePoint BestOfPiece(const Piece& piece, const ReceptorField& receptors) {
  constexpr int kLattice = 9;
  const MotorSource source = SourceOf(piece.problem.actuator, piece.problem.drive);
  const auto value = [&](const std::vector<double>& place) {
    const auto point = PointAt(piece.problem, source, place);
    return point ? ValueOf(piece.objective, piece.problem, source, receptors, *point) : 0;
  };
  const AdapterBounds& bounds = piece.problem.bounds;
  std::vector<bool> fixed{IsPoint(bounds.motor_side_mass_kg), IsPoint(bounds.stiffness_n_per_m),
                          IsPoint(bounds.damping_n_s_per_m),
                          piece.problem.fixed_skin || IsPoint(bounds.contact_area_m2)};
  // the electrical power wants another Ma2 than the skin's motion
  if (piece.objective == Objective::kRmsPerWatt) fixed.push_back(IsPoint(bounds.skin_side_mass_kg));
  const CubePoint best = SearchCube(value, fixed, kLattice);
  const auto point = PointAt(piece.problem, source, best.place);
  if (!point) return {};
  return {.point = *point, .value = piece.weight * best.value};
}

RidgePoint Best(Objective objective, const TuningProblem& problem, const ReceptorField& receptors) {
  RidgePoint best;
  for (const Piece& piece : PiecesOf(objective, problem, receptors)) {
    const RidgePoint found = BestOfPiece(piece, receptors);
    if (found.value > best.value) best = found;
  }
  return best;
}

struct OpenBox {
  AdapterBox box;
  BoxCost cost{};
};
// the box that may hold the least cost comes first
struct Costlier {
  bool operator()(const OpenBox& a, const OpenBox& b) const { return a.cost.lower > b.cost.lower; }
};
using OpenBoxes = std::priority_queue<OpenBox, std::vector<OpenBox>, Costlier>;

// A lower bound of the cost over the piece: at least `enough`, or the best that the boxes allow.
double LeastCost(const Piece& piece, const MotorSource& source, double enough,
                 std::size_t most_boxes, std::size_t& boxes) {
  const AdapterCost cost(piece.problem, source, piece.objective == Objective::kSkinPower);
  OpenBoxes open;
  AdapterBox whole;
  whole.fill({.lower = 0, .upper = 1});
  open.push({.box = whole, .cost = cost.Over(whole)});
  while (open.top().cost.lower < enough && boxes < most_boxes) {
    const OpenBox first = open.top();
    open.pop();
    const auto widest = std::ranges::max_element(first.cost.spread);
    const auto axis = static_cast<std::size_t>(widest - first.cost.spread.begin());
    OpenBox lower{.box = first.box};
    OpenBox upper{.box = first.box};
    lower.box[axis].upper = upper.box[axis].lower = first.box[axis].middle();
    for (OpenBox* half : {&lower, &upper}) {
      half->cost = cost.Over(half->box);
      open.push(*half);
    }
    boxes += 2;
  }
  return open.top().cost.lower;
}

// the objective that a cost means, rounded upwards by the allowance
double ValueOfCost(const Piece& piece, const MotorSource& source, double cost) {
  const double half_square = std::norm(source.force_n) / 2 / cost;
  return piece.objective == Objective::kSkinPower ? source.omega_rad_per_s * half_square
                                                  : piece.weight * std::sqrt(half_square);
}
double CostOfValue(const Piece& piece, const MotorSource& source, double value) {
  const double half_square = piece.objective == Objective::kSkinPower
                                 ? value / source.omega_rad_per_s
                                 : std::pow(value / piece.weight, 2);
  return std::norm(source.force_n) / 2 / half_square;
}

}  // namespace

AdapterPoint BestAdapter(Objective objective, const TuningProblem& problem,
                         const ReceptorField& receptors) {
  return Best(objective, problem, receptors).point;
}

namespace {

AdapterOptimum WithinTravel(Objective objective, const TuningProblem& problem,
                            const ReceptorField& receptors, const AdapterOptimum& unlimited) {
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const Skin skin = SkinOf(problem, unlimited.point.contact_area_m2);
  const AdapterMotion motion = MotionOf(source, unlimited.point.adapter, skin);
  if (MoverTravel(source, motion.case_m) <= problem.mover_limit_m) return unlimited;
  const RidgePoint best = Best(objective, problem, receptors);
  AdapterOptimum optimum = unlimited;
  optimum.point = best.point;
  optimum.value = best.value;
  const double bound = LimitedTravelBound(objective, problem, source, receptors);
  if (bound < unlimited.upper_bound) {
    optimum.upper_bound = bound;
    optimum.proof = Proof::kLimitedTravel;
  }
  return optimum;
}

}  // namespace

AdapterOptimum FindAdapterOptimum(Objective objective, const TuningProblem& problem,
                                  const ReceptorField& receptors, double relative_gap,
                                  std::size_t most_boxes) {
  if (std::isfinite(problem.mover_limit_m)) {
    HAPTOMETER_CHECK(objective != Objective::kRmsPerWatt && problem.skin_variation == 0,
                     "{} of skins that vary by {} with limited travel", Name(objective),
                     problem.skin_variation);
    TuningProblem free = problem;
    free.mover_limit_m = std::numeric_limits<double>::infinity();
    return WithinTravel(objective, problem, receptors,
                        FindAdapterOptimum(objective, free, receptors, relative_gap, most_boxes));
  }
  HAPTOMETER_CHECK(!Fault(problem) && relative_gap > 0, "gap {}", relative_gap);
  HAPTOMETER_CHECK(problem.skin_variation == 0 || objective == Objective::kSkinRms ||
                       objective == Objective::kStimulus,
                   "{} of skins that vary", Name(objective));
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const RidgePoint best = Best(objective, problem, receptors);
  AdapterOptimum optimum{.point = best.point,
                         .value = best.value,
                         .upper_bound = MatchedLoadBound(objective, problem, source, receptors)};
  const bool steps = HasSteps(objective, receptors);
  const bool provable = objective == Objective::kSkinRms || objective == Objective::kSkinPower;
  if (!provable && !steps) return optimum;

  // the largest of the pieces' bounds, each no lower than the best point found
  const double allowed = 1 + source.rounding_allowance + (steps ? kStepAllowance : 0);
  double bound = best.value;
  for (const Piece& piece : PiecesOf(objective, problem, receptors)) {
    if (!(piece.weight > 0)) continue;
    const double enough = CostOfValue(piece, source, best.value * (1 + relative_gap));
    const double cost = LeastCost(piece, source, enough, most_boxes, optimum.boxes);
    bound = std::max(bound, ValueOfCost(piece, source, cost));
  }
  if (bound * allowed < optimum.upper_bound) {
    optimum.upper_bound = bound * allowed;
    optimum.proof = Proof::kBranchAndBound;
  }
  return optimum;
}

std::vector<RidgePoint> RidgeOf(Objective objective, const TuningProblem& problem,
                                const ReceptorField& receptors, std::size_t values) {
  HAPTOMETER_CHECK(values >= 2, "{} values", values);
  std::vector<RidgePoint> ridge;
  ridge.reserve(values);
  for (const double mass_kg : EqualSteps(problem.bounds.motor_side_mass_kg, values)) {
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
