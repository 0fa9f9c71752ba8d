#pragma once

#include <Eigen/Core>

#include "sim/tuning/adapter_objective.h"

namespace haptometer::sim {

/// Ma1, Ka, Ba, the area by AreaAt() and Ma2, each as its part of the way between its bounds.
inline constexpr int kCubeAxes = 5;
using CubePlace = Eigen::Matrix<double, kCubeAxes, 1>;

/// The adapter at a place.
[[nodiscard]] AdapterPoint PointOf(const AdapterBounds& bounds, const CubePlace& place);

/// What a place costs and how far the mover is beyond its limit there, with slopes.
struct LimitedView {
  double cost = 0;    ///< f = ln |Fc / Xs|^2, less the logarithm of what the objective weighs it by
  double excess = 0;  ///< h = ln(|travel|^2 / limit^2): kept where it is not above 0
  CubePlace cost_slopes = CubePlace::Zero();
  CubePlace excess_slopes = CubePlace::Zero();
};

/// Where a climb ended.
struct LimitedSummit {
  CubePlace place = CubePlace::Zero();
  double price = 0;   ///< lambda: by how much ln cost falls where ln limit^2 grows
  double cost = 0;    ///< f
  bool kept = false;  ///< the limit is, to 1e-11 of it
};

/// Climbs to adapters whose mover keeps to the problem's mover_limit_m.
///
/// f is made least under h <= 0 with all five numbers free: eliminating Ma2 bends and narrows the
/// ridge, on which searches without slopes stop. The augmented Lagrangian of Hestenes, Powell and
/// Rockafellar (Nocedal and Wright, Numerical Optimization, 2nd edition, section 17.3)
///
///   f + (rho / 2) max(0, h + lambda / rho)^2
///
/// is made least over the cube by damped Newton steps projected onto it (Bertsekas, SIAM J. Control
/// Optim. 20 (1982) 221), then lambda <- max(0, lambda + rho h), until h or lambda is 0 to
/// rounding. Slopes are exact, second ones are central differences of them.
class LimitedClimb {
 public:
  /// The problem without Fault(), skin_variation 0, mover_limit_m finite or not; not kRmsPerWatt.
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
  CubePlace free_;  // 1 where the bounds leave an axis free
};

}  // namespace haptometer::sim
