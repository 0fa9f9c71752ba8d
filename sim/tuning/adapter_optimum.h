#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/tuning/adapter_objective.h"

namespace haptometer::sim {

/// How an upper bound was proved.
enum class Proof : std::uint8_t {
  kBranchAndBound,  ///< boxes that cover the bounds, by interval arithmetic
  kMatchedLoad,     ///< MatchedLoadBound(): true of any adapter, looser
  kLimitedTravel,   ///< LimitedTravelBound(): true of any adapter, looser
};

/// The best adapter within the bounds.
struct AdapterOptimum {
  AdapterPoint point;
  double value = 0;        ///< the objective there, in its unit
  double upper_bound = 0;  ///< no point within the bounds gives more
  Proof proof = Proof::kMatchedLoad;
  std::size_t boxes = 0;  ///< looked at for the proof, over all stretches of areas
};

/// The best point with a certified upper bound. The problem must have no Fault().
///
/// The proof, for kSkinRms, kStimulus and kSkinPower. |Xs| depends on Ma2 through one square only,
/// so Ma2 takes the value that serves best and four numbers are left: Ma1, Ka, Ba and the area's
/// part. Im(D1 + ka) >= q > 0, so nothing is divided by 0 anywhere in the bounds; where Ma2 meets
/// its bound the cost bends, and its slopes there are an interval too. Boxes that cover the bounds
/// have a lower bound of the cost (sim/tuning/adapter_cost.h) in interval arithmetic that rounds
/// outwards. The box with the weakest bound is halved across its widest contribution until that
/// bound is within `relative_gap` of the best point, or `most_boxes` have been looked at; whichever
/// comes first, the weakest bound that is left is the answer; where the middle of a box is better
/// than the best point, it and a climb from it take that point's place. kStimulus is the same for
/// each stretch of areas between two steps of Nr, whose weight is constant on it (sharp field edges
/// only), each with `most_boxes` of its own; kSkinPower divides by b. kRmsPerWatt has
/// MatchedLoadBound() alone, and so has a stimulus with soft edges.
///
/// With a skin_variation (kSkinRms and kStimulus only) the least RMS over those skins is made as
/// large as it can be, and the nearest Ma2 is still the best.
///
/// With a mover_limit_m (not for kRmsPerWatt, nor with a skin_variation) the best point is sought
/// among those that keep to it; where the unlimited optimum does, it is the answer, with its proof.
/// Else the proof has a price of travel (BoundWithinTravel()), boxes again.
/// Either way LimitedTravelBound() and MatchedLoadBound() are told where they are lower. value 0:
/// none found. ValueOf() itself knows no limit.
///
/// Rounding: the intervals begin from kc and Fc as rounded; MotorSource::rounding_allowance
/// (2.5e-11 for the thesis's actuator) is added for that.
///
/// Worked: the thesis's problem gives Ma1 0.25 g, Ma2 4.9205 g, Ka 9276.2 N/m, Ba 0.01 N s/m, A 1
/// mm2, 0.20188526 mm, and a bound 4e-10 above it. Cost: docs/developer/results.md; allocates the
/// boxes.
[[nodiscard]] AdapterOptimum FindAdapterOptimum(Objective objective, const TuningProblem& problem,
                                                const ReceptorField& receptors,
                                                double relative_gap = 1e-9,
                                                std::size_t most_boxes = 100'000);

/// One point of the ridge: the best there is with that mass on the motor's side.
struct RidgePoint {
  AdapterPoint point;
  double value = 0;
};

/// The best point at each of `values` >= 2 masses on the motor's side, evenly over its bounds; none
/// for a mass with which no mover keeps to its limit.
[[nodiscard]] std::vector<RidgePoint> RidgeOf(Objective objective, const TuningProblem& problem,
                                              const ReceptorField& receptors, std::size_t values);

/// What a spring costs that is not the one that was asked for.
struct SpringCost {
  double factor = 1;    ///< stiffness over the wanted one
  double as_built = 0;  ///< the objective with nothing else changed, whatever the mover's travel
  /// with the skin side's mass chosen anew within its bounds and the mover's limit; 0: none found
  double rebalanced = 0;
};

[[nodiscard]] SpringCost CostOfSpring(Objective objective, const TuningProblem& problem,
                                      const ReceptorField& receptors, const AdapterPoint& point,
                                      double factor);

}  // namespace haptometer::sim
