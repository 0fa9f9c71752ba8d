#include "sim/tuning/limited_optimum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <optional>

#include "base/error.h"
#include "sim/tuning/adapter_cost.h"
#include "sim/tuning/area_pieces.h"
#include "sim/tuning/box_search.h"
#include "sim/tuning/climb_starts.h"
#include "sim/tuning/cube_place.h"
#include "sim/tuning/limited_climb.h"
#include "sim/tuning/travel_limit.h"

namespace haptometer::sim {

namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

// a place of the lattice and how good it is to begin at: the less, the better
struct Start {
  CubePlace place = CubePlace::Zero();
  double rank = kNone;
  void Offer(const CubePlace& other, double other_rank) {
    if (other_rank < rank) *this = {.place = other, .rank = other_rank};
  }
};

// of each third of Ma1 and of Ka, and of RMS per watt of all axes, those that keep to the limit and
// those that do not
struct Starts {
  std::array<Start, std::size_t{3} * kCubeAxes> kept, beyond;
};

// Ma2 to begin with: what the skin's motion wants; that of RMS per watt lies beside it
std::vector<double> MassesToTry(const AreaPiece& piece, const MotorSource& source,
                                const AdapterPoint& point) {
  const double wanted_kg = WantedSkinSideMass(piece.problem, source, point);
  if (piece.objective != Objective::kRmsPerWatt) return {wanted_kg};
  const double w = source.omega_rad_per_s;
  const double Bs = SkinOf(piece.problem, point.contact_area_m2).damping_n_s_per_m;
  const Range& mass_kg = piece.problem.bounds.skin_side_mass_kg;
  return {wanted_kg, wanted_kg - Bs / w, wanted_kg + Bs / w, mass_kg.lower, mass_kg.upper};
}

Starts StartsOf(const AreaPiece& piece, const MotorSource& source, const LimitedClimb& climb) {
  const TuningProblem& problem = piece.problem;
  const Range& mass_kg = problem.bounds.skin_side_mass_kg;
  const auto third = [](double part) {
    return std::min<std::size_t>(2, static_cast<std::size_t>(part * 3));
  };
  const int axes = piece.objective == Objective::kRmsPerWatt ? kCubeAxes : 2;
  Starts starts;
  for (CubePlace place : StartPlaces(problem, source)) {
    const AdapterPoint point = PointOf(problem.bounds, place);
    for (const double wanted_kg : MassesToTry(piece, source, point)) {
      const auto found_kg = NearestWithinTravel(problem, source, point, wanted_kg);
      const double kg = found_kg.value_or(std::clamp(wanted_kg, mass_kg.lower, mass_kg.upper));
      place[4] = PartOf(mass_kg, kg);
      const LimitedView view = climb.At(place);
      auto& kind = found_kg ? starts.kept : starts.beyond;
      const double rank = found_kg ? view.cost : view.excess;
      for (int axis = 0; axis < axes; ++axis) {
        kind[static_cast<std::size_t>(3 * axis) + third(place[axis])].Offer(place, rank);
      }
    }
  }
  return starts;
}

// the best of a stretch of areas
struct PieceBest {
  AdapterPoint point;
  double value = 0;
  double price = 0;
};

PieceBest BestOfPiece(const AreaPiece& piece, const MotorSource& source,
                      const ReceptorField& receptors) {
  const LimitedClimb climb(piece.objective, piece.problem, source, receptors);
  const Starts starts = StartsOf(piece, source, climb);
  const bool any = std::ranges::any_of(starts.kept, [](const Start& s) { return s.rank < kNone; });
  std::optional<LimitedSummit> best;
  for (const Start& start : any ? starts.kept : starts.beyond) {
    if (start.rank == kNone) continue;
    const LimitedSummit summit = climb.From(start.place);
    if (summit.kept && (!best || summit.cost < best->cost)) best = summit;
  }
  if (!best) return {};
  const AdapterPoint point = PointOf(piece.problem.bounds, best->place);
  return {.point = point,
          .value = piece.weight * ValueOf(piece.objective, piece.problem, source, receptors, point),
          .price = best->price};
}

// what the stretch cannot exceed by the coil's work alone
double RoughBound(const AreaPiece& piece, const MotorSource& source,
                  const ReceptorField& receptors) {
  if (piece.objective == Objective::kRmsPerWatt) return kNone;
  return piece.weight * LimitedTravelBound(piece.objective, piece.problem, source, receptors);
}

}  // namespace

LimitedBest BestWithinTravel(Objective objective, const TuningProblem& problem,
                             const ReceptorField& receptors) {
  HAPTOMETER_CHECK(!Fault(problem) && problem.skin_variation == 0, "limit {}, variation {}",
                   problem.mover_limit_m, problem.skin_variation);
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  LimitedBest best;
  for (const AreaPiece& piece : PiecesOf(objective, problem, receptors)) {
    best.prices.push_back(-1);
    if (!(RoughBound(piece, source, receptors) > best.value)) continue;
    const PieceBest found = BestOfPiece(piece, source, receptors);
    best.prices.back() = found.price;
    if (!(found.value > best.value)) continue;
    best.point = found.point;
    best.value = found.value;
  }
  return best;
}

TravelBound BoundWithinTravel(Objective objective, const TuningProblem& problem,
                              const ReceptorField& receptors, const LimitedBest& best,
                              double relative_gap, std::size_t most_boxes) {
  const bool steps = HasSteps(objective, receptors);
  if (objective == Objective::kStimulus && !steps) return {.value = kNone};
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const std::vector<AreaPiece> pieces = PiecesOf(objective, problem, receptors);
  HAPTOMETER_CHECK(pieces.size() == best.prices.size() && best.value > 0, "{} pieces, value {}",
                   pieces.size(), best.value);
  TravelBound bound;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    const AreaPiece& piece = pieces[k];
    const double rough = RoughBound(piece, source, receptors);
    if (!(rough > best.value)) {
      bound.value = std::max(bound.value, rough);
      continue;
    }
    // any price below 1 gives a bound
    const double price = std::clamp(best.prices[k], 0.0, 1 - 1e-6);
    const AdapterCost cost(piece.problem, source, piece.objective == Objective::kSkinPower, price);
    const double enough = CostOfValue(piece, source, best.value * (1 + relative_gap));
    const LeastOfBoxes least =
        LeastCost([&](const AdapterBox& box) { return cost.Over(box); }, enough, most_boxes);
    bound.boxes += least.boxes;
    bound.value = std::max(bound.value, std::min(rough, ValueOfCost(piece, source, least.cost)));
  }
  // what the rounding of source and limit may move: travel is a difference of two; a price is 1 at
  // most, so that the value moves by no more than the limit's square
  const double squares = objective == Objective::kSkinPower ? 2 : 1;  // of an RMS
  const double travel = 1 + std::abs(source.free_travel_m) / problem.mover_limit_m;
  bound.value *=
      1 + squares * source.rounding_allowance * travel + kKeptLimit + (steps ? kStepAllowance : 0);
  return bound;
}

}  // namespace haptometer::sim
