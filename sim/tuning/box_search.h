#pragma once

#include <cstddef>
#include <functional>

#include "sim/tuning/adapter_box.h"

namespace haptometer::sim {

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
