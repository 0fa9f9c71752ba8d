#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "sim/linear/motor_source.h"
#include "sim/skin/skin.h"
#include "sim/tuning/adapter_objective.h"
#include "sim/tuning/search.h"
#include "sim/tuning/tuning_problem.h"

namespace haptometer::sim {

/// The mass on the skin's side that would serve |Xs| best, whatever its bounds and the limit:
/// (Ks + Re Z) / w^2, Z = D1 ka / (D1 + ka) (sim/tuning/adapter_grid.h).
[[nodiscard]] double WantedSkinSideMass(const TuningProblem& problem, const MotorSource& source,
                                        const AdapterPoint& point);

/// The mass on the skin's side nearest to `wanted_kg`, within its bounds, with which the mover
/// keeps to the problem's mover_limit_m; nothing where none does. `point` gives all but that mass.
///
/// With y = Ma2 w^2 and motor_source.h's letters the travel is |p - Q y| / |d - U y|,
///
///   Q = (1 - k1/d1) Fc / ka + (F/d1) U,   p = (1 - k1/d1) Fc + (F/d1) D1 + Q (Ks + Bs s),
///   U = 1 + D1 / ka,                      d = D1 + U (Ks + Bs s),
///
/// so that the limit T is a quadratic inequality in y, |p - Q y|^2 <= T^2 |d - U y|^2, whose roots
/// and the ends of the bounds are all there is to look at. |Xs| falls with the distance of y from
/// where it is largest, so for the skin's motion the nearest is the best. Cost: 0.1 us.
[[nodiscard]] std::optional<double> NearestWithinTravel(const TuningProblem& problem,
                                                        const MotorSource& source,
                                                        const AdapterPoint& point,
                                                        double wanted_kg);

/// What no adapter can exceed whose mover keeps to the limit T, with a skin damping of Bs at least
/// the lowest that the bounds allow: kSkinRms, kStimulus (every receptor reached) and kSkinPower.
///
/// The coil's force F puts in w |F| T / 2 at most, of which the mover's own damping takes
/// Im k1 w T^2 / 2, and the skin's w (w Bs) |Xs|^2 / 2 cannot be more than what is left:
///
///   |Xs|^2 <= (|F| T - Im k1 T^2) / (w Bs)      for T <= |F| / (2 Im k1);
///
/// for a longer T it holds with that one. Rounding is allowed for, and kKeptLimit of
/// sim/tuning/search.h.
[[nodiscard]] double LimitedTravelBound(Objective objective, const TuningProblem& problem,
                                        const MotorSource& source, const ReceptorField& receptors);

/// Places to begin a climb at, all but Ma2, which is 0: a lattice, and the ridge.
///
/// The lattice has 9 places an axis, evenly over the cube; evenly over the logarithm of what moves
/// with the case, Mc + Ma1, where that spans more than a factor of 20, and in steps of 8 down from
/// the upper end where Ba may be 0.
///
/// The ridge, whatever the bounds' width: with sim/tuning/adapter_cost.h's letters (no price) and
/// g = 0 the cost is least over S where S = h / b, which is
///
///   b ((Ka + p)^2 + (e + q)^2) = q (Ka^2 + e^2) + e (p^2 + q^2),
///
/// a square in Ka and one in p, so in Ma1. Each is solved with the others on the lattice; without a
/// root within the bounds its end stands for it.
[[nodiscard]] std::vector<CubePlace> StartPlaces(const TuningProblem& problem,
                                                 const MotorSource& source);

/// Climbs to adapters whose mover keeps to the problem's mover_limit_m.
///
/// f = ln |Fc / Xs|^2, less the logarithm of what the objective weighs it by (w Bs of kSkinPower,
/// Nr^2 of a soft-edged stimulus, 1 / P^2 of kRmsPerWatt), is made least under h = ln(|travel|^2 /
/// limit^2) <= 0 by ClimbWithinBounds(), all five numbers free: eliminating Ma2 bends and narrows
/// the ridge, on which searches without slopes stop.
///
/// Where skins vary (skin_variation above 0, no limit of travel), the least motion has a kink where
/// the hardest skin changes. So f is that of the skin at one end of Ks, and h <= 0 says that the
/// other end's moves no less: min over max(f1, f2) is the lesser of both climbs.
class LimitedClimb {
 public:
  /// The problem without Fault(). `hardest`: +1 or -1, the end of Ks that moves least, of skins
  /// that vary; 0 of others.
  LimitedClimb(Objective objective, const TuningProblem& problem, const MotorSource& source,
               const ReceptorField& receptors, int hardest = 0);

  /// Exact to rounding; the slope of a soft-edged stimulus's Nr is a central difference.
  [[nodiscard]] LimitedView At(const CubePlace& place) const;

  /// The local optimum above `start`. Cost: below a millisecond; no allocation.
  [[nodiscard]] LimitedSummit From(const CubePlace& start) const;

 private:
  [[nodiscard]] LimitedView ViewOf(const CubePlace& place, int side) const;
  [[nodiscard]] double LogWeight(double part) const;

  Objective objective_;
  TuningProblem problem_;
  MotorSource source_;
  ReceptorField receptors_;
  int hardest_;
  CubePlace upper_;
  Skin first_, last_;  // at the ends of the contact's area
};

/// The best adapter whose mover keeps to the problem's mover_limit_m.
struct LimitedBest {
  AdapterPoint point{};
  double value = 0;  ///< the objective there; 0: no adapter found that keeps to the limit
  /// Of each stretch of areas (sim/tuning/adapter_objective.h), the price of travel at its best;
  /// below 0 where the stretch was left out because LimitedTravelBound() of it is below the value.
  std::vector<double> prices{};
};

/// Climbs from the best of StartPlaces() in which Ma2 is the nearest that keeps to the limit: the
/// best of each third of Ma1's range and of Ka's, of kRmsPerWatt of every number's. Where there is
/// none, from those with the least travel.
///
/// The problem without Fault(), mover_limit_m finite or not (not, for kRmsPerWatt and for skins
/// that vary).
/// The same optimum as SciPy's SLSQP finds from 20 starts, to 1e-9 of the value, over the limits
/// and problems of tests/sim/tuning/limited_reference.py. Cost: some 10 ms a stretch of areas.
[[nodiscard]] LimitedBest BestWithinTravel(Objective objective, const TuningProblem& problem,
                                           const ReceptorField& receptors);

/// What no adapter exceeds whose mover keeps to the limit.
struct TravelBound {
  double value = 0;       ///< of the objective; infinite: no proof
  std::size_t boxes = 0;  ///< looked at, over all stretches of areas
};

/// The bound of the adapters within the bounds; none for kRmsPerWatt and for a stimulus with soft
/// edges. It is what the boxes say, not lifted to the value that was found: below that value it
/// would be wrong. At most `most_boxes` of each stretch of areas.
///
/// Without a limit of travel, where the middle of a box is better than `best`, it and a climb from
/// it take that point's place.
///
/// With one, by weak duality (sim/tuning/adapter_cost.h) with the price of travel at `best`. It
/// comes within `relative_gap`, or within 2.1e-9, which is what its allowances for rounding leave,
/// where the duality has no gap: so it has been in all problems of
/// tests/sim/tuning/limited_reference.h, with 50 to 1200 boxes. Where the best has a price above 1,
/// the skin's motion growing faster than the travel, as narrow bounds of Ma2 can make it, there is
/// a gap: the bound then stays above the optimum, whatever the boxes. Of 175 random problems
/// (tests/sim/tuning/random_problems_test.cc is of that kind) 14 had one, of 0.3 to 225 %.
[[nodiscard]] TravelBound BoundWithinTravel(Objective objective, const TuningProblem& problem,
                                            const ReceptorField& receptors, double relative_gap,
                                            std::size_t most_boxes, LimitedBest& best);

}  // namespace haptometer::sim
