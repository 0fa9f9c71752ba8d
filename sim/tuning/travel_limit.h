#pragma once

#include <optional>

#include "sim/receptors.h"
#include "sim/tuning/adapter_bounds.h"
#include "sim/tuning/adapter_objective.h"
#include "sim/tuning/motor_source.h"

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
/// sim/tuning/bounded_climb.h.
[[nodiscard]] double LimitedTravelBound(Objective objective, const TuningProblem& problem,
                                        const MotorSource& source, const ReceptorField& receptors);

}  // namespace haptometer::sim
