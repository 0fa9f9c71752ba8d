#pragma once

#include "sim/tuning/adapter_objective.h"
#include "sim/tuning/bounded_climb.h"

namespace haptometer::sim {

/// Climbs to adapters whose mover keeps to the problem's mover_limit_m.
///
/// f = ln |Fc / Xs|^2, less the logarithm of what the objective weighs it by (w Bs of kSkinPower,
/// Nr^2 of a soft-edged stimulus, 1 / P^2 of kRmsPerWatt), is made least under h = ln(|travel|^2 /
/// limit^2) <= 0 by ClimbWithinBounds(), all five numbers free: eliminating Ma2 bends and narrows
/// the ridge, on which searches without slopes stop.
class LimitedClimb {
 public:
  /// The problem without Fault(), skin_variation 0, mover_limit_m finite or not.
  LimitedClimb(Objective objective, const TuningProblem& problem, const MotorSource& source,
               const ReceptorField& receptors);

  /// Exact to rounding; the slope of a soft-edged stimulus's Nr is a central difference.
  [[nodiscard]] LimitedView At(const CubePlace& place) const;

  /// The local optimum above `start`. Cost: below a millisecond; no allocation.
  [[nodiscard]] LimitedSummit From(const CubePlace& start) const;

 private:
  [[nodiscard]] double LogWeight(double part) const;

  Objective objective_;
  TuningProblem problem_;
  MotorSource source_;
  ReceptorField receptors_;
  CubePlace upper_;
};

}  // namespace haptometer::sim
