#pragma once

#include <cstddef>
#include <vector>

#include "sim/tuning/adapter_bounds.h"
#include "sim/tuning/adapter_objective.h"

namespace haptometer::sim {

/// The best adapter whose mover keeps to the problem's mover_limit_m.
struct LimitedBest {
  AdapterPoint point;
  double value = 0;  ///< the objective there; 0: no adapter found that keeps to the limit
  /// Of each stretch of areas (sim/tuning/area_pieces.h), the price of travel at its best; below 0
  /// where the stretch was left out because LimitedTravelBound() of it is below the value.
  std::vector<double> prices;
};

/// Climbs (sim/tuning/limited_climb.h) from the best of StartPlaces() (sim/tuning/climb_starts.h)
/// in which Ma2 is the nearest that keeps to the limit: the best of each third of Ma1's range and
/// of Ka's, of kRmsPerWatt of every number's. Where there is none, from those with the least
/// travel.
///
/// The problem without Fault(), skin_variation 0, mover_limit_m finite or not (not, for
/// kRmsPerWatt).
/// The same optimum as SciPy's SLSQP finds from 20 starts, to 1e-9 of the value, over the limits
/// and problems of tests/sim/tuning/limited_reference.py. Cost: some 10 ms a stretch of areas.
[[nodiscard]] LimitedBest BestWithinTravel(Objective objective, const TuningProblem& problem,
                                           const ReceptorField& receptors);

/// What no adapter exceeds whose mover keeps to the limit.
struct TravelBound {
  double value = 0;       ///< of the objective; infinite: no proof
  std::size_t boxes = 0;  ///< looked at, over all stretches of areas
};

/// The bound of the adapters within the bounds; none for a stimulus with soft edges. It is what the
/// boxes say, not lifted to the value that was found: below that value it would be wrong.
///
/// By weak duality (sim/tuning/adapter_cost.h) with the price of travel at `best`, and boxes, at
/// most `most_boxes` of each stretch of areas. It comes within `relative_gap`, or within some 3e-9,
/// to which the price is known, where the duality has no gap: so it has been in all problems of
/// tests/sim/tuning/limited_reference.h, with 50 to 1200 boxes. Where the best has a price above 1,
/// the skin's motion growing faster than the travel, as narrow bounds of Ma2 can make it, there is
/// a gap: the bound then stays above the optimum, whatever the boxes. Of 175 random problems
/// (tests/sim/tuning/random_problems_test.cc is of that kind) 14 had one, of 0.3 to 225 %.
[[nodiscard]] TravelBound BoundWithinTravel(Objective objective, const TuningProblem& problem,
                                            const ReceptorField& receptors, const LimitedBest& best,
                                            double relative_gap, std::size_t most_boxes);

}  // namespace haptometer::sim
