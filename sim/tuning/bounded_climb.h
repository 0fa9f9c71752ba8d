#pragma once

#include <functional>

#include "sim/tuning/cube_place.h"

namespace haptometer::sim {

/// What a place costs and how far it is beyond a limit, with slopes.
struct LimitedView {
  double cost = 0;    ///< f, to be made least
  double excess = 0;  ///< h, kept where it is not above 0; -inf: no limit
  CubePlace cost_slopes = CubePlace::Zero();
  CubePlace excess_slopes = CubePlace::Zero();
};

/// A limit counts as kept where h is no more than this.
inline constexpr double kKeptLimit = 1e-11;

/// Where a climb ended.
struct LimitedSummit {
  CubePlace place = CubePlace::Zero();
  double price = 0;   ///< lambda: by how much the cost falls where the limit is let out
  double cost = 0;    ///< f
  bool kept = false;  ///< h <= kKeptLimit
};

/// The local minimum of f under h <= 0 and lower <= place <= upper that is reached from `start`.
///
/// The augmented Lagrangian of Hestenes, Powell and Rockafellar (Nocedal and Wright, Numerical
/// Optimization, 2nd edition, section 17.3)
///
///   f + (rho / 2) max(0, h + lambda / rho)^2
///
/// is made least within the bounds by damped Newton steps projected onto them (Bertsekas, SIAM J.
/// Control Optim. 20 (1982) 221), then lambda <- max(0, lambda + rho h), until h or lambda is 0 to
/// rounding. Second slopes are central differences of the slopes, taken 1e-6 beyond the bounds too.
/// An axis with equal bounds stays. Bounds are met exactly. Cost: some 50 steps of 13 views.
[[nodiscard]] LimitedSummit ClimbWithinBounds(
    const std::function<LimitedView(const CubePlace&)>& view, const CubePlace& lower,
    const CubePlace& upper, const CubePlace& start);

}  // namespace haptometer::sim
