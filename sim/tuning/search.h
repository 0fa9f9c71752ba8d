#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "sim/tuning/adapter_cost.h"
#include "sim/tuning/tuning_problem.h"

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
  double price = 0;   ///< lambda: by how much the cost falls where the limit is let out, to 1e-12
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
/// An axis with equal bounds stays. Bounds are met exactly. The price comes from a Newton step of
/// the slopes at the end: the merit, which is flat to rounding there, leaves 1e-4 of it open. Cost:
/// some 50 steps of 13 views.
[[nodiscard]] LimitedSummit ClimbWithinBounds(
    const std::function<LimitedView(const CubePlace&)>& view, const CubePlace& lower,
    const CubePlace& upper, const CubePlace& start);

/// What boxes prove.
struct LeastOfBoxes {
  double cost = 0;        ///< no adapter of the bounds costs less
  std::size_t boxes = 0;  ///< looked at
  AdapterBox reached{};   ///< of all boxes the one whose middle costs least
};

/// A lower bound of a cost over all adapters of the bounds: at least `enough`, or within 1e-10 of
/// the cost of some adapter, or the best that some `most_boxes` boxes allow.
///
/// Boxes cover the bounds; the one with the weakest bound comes first and is halved across its
/// widest contribution. Where the cost rises all over a box along an axis, the least of all lies in
/// that box only if the box begins at the axis's lower bound, and then on that face (the
/// monotonicity test of Hansen and Walster, Global Optimization Using Interval Analysis, 2nd
/// edition, section 12.4): such boxes are dropped or flattened. `over` must be of one cost for all
/// boxes.
///
/// Cost: some us a box; allocates the boxes.
[[nodiscard]] LeastOfBoxes LeastCost(const std::function<BoxCost(const AdapterBox&)>& over,
                                     double enough, std::size_t most_boxes);

}  // namespace haptometer::sim
