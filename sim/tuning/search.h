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

/// A point of the unit cube and the function's value there.
struct CubePoint {
  std::vector<double> place;  ///< each from 0 to 1
  double value = 0;
};

/// Climbs from `start` to a local maximum of `function` within the unit cube of as many dimensions.
///
/// Compass search (Kolda, Lewis, Torczon, SIAM Review 45 (2003) 385, section 3) with all 3^n - 1
/// neighbours: steps to the best of them while it is better by 16 roundings of the value, at most
/// 1000 times, then halves the step, from 2^-4 down to 2^-40: on a flat ridge the last bits of the
/// value would be climbed for minutes. Without derivatives and deterministic; bounds are met
/// exactly. A smooth maximum is found to about the root of the function's rounding. Cost: 3^n - 1
/// evaluations a step, some hundred steps; n is 5 at most here.
[[nodiscard]] CubePoint ClimbWithinCube(
    const std::function<double(const std::vector<double>&)>& function, std::vector<double> start);

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
