#include "sim/tuning/box_search.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <queue>
#include <vector>

namespace haptometer::sim {

namespace {

using Cost = std::function<BoxCost(const AdapterBox&)>;

// a bound that comes so near to the cost of an adapter cannot be raised further
constexpr double kSettled = 1e-10;

struct OpenBox {
  AdapterBox box;
  BoxCost cost{};
};
// the box that may hold the least cost comes first
struct Costlier {
  bool operator()(const OpenBox& a, const OpenBox& b) const { return a.cost.lower > b.cost.lower; }
};
using OpenBoxes = std::priority_queue<OpenBox, std::vector<OpenBox>, Costlier>;

enum class Fate : std::uint8_t { kKept, kFlattened, kDropped };

// what the trend along one axis makes of its interval
Fate FateOf(Interval& axis, int trend) {
  if (trend == 0 || axis.lower == axis.upper) return Fate::kKept;
  const double bound = trend > 0 ? 0 : 1;
  if ((trend > 0 ? axis.lower : axis.upper) != bound) return Fate::kDropped;
  axis = Interval::Of(bound);
  return Fate::kFlattened;
}

// Bounds the box, flattened as far as it may be; false where it cannot hold the least.
bool Bound(const Cost& over, OpenBox& open) {
  for (bool flattened = true; flattened;) {
    open.cost = over(open.box);
    flattened = false;
    for (std::size_t axis = 0; axis < kBoxAxes; ++axis) {
      const Fate fate = FateOf(open.box[axis], open.cost.trend[axis]);
      if (fate == Fate::kDropped) return false;
      flattened = flattened || fate == Fate::kFlattened;
    }
  }
  return true;
}

}  // namespace

LeastOfBoxes LeastCost(const Cost& over, double enough, std::size_t most_boxes) {
  OpenBox whole;
  whole.box.fill({.lower = 0, .upper = 1});
  Bound(over, whole);
  OpenBoxes open;
  open.push(whole);
  std::size_t boxes = 1;
  OpenBox best = whole;  // by its middle
  const auto open_by = [&] { return std::min(enough, (1 - kSettled) * best.cost.middle); };
  while (!open.empty() && open.top().cost.lower < open_by() && boxes < most_boxes) {
    const OpenBox first = open.top();
    open.pop();
    const auto widest = std::ranges::max_element(first.cost.spread);
    const auto axis = static_cast<std::size_t>(widest - first.cost.spread.begin());
    OpenBox lower{.box = first.box};
    OpenBox upper{.box = first.box};
    lower.box[axis].upper = upper.box[axis].lower = first.box[axis].middle();
    for (OpenBox* half : {&lower, &upper}) {
      if (!Bound(over, *half)) continue;
      if (half->cost.middle < best.cost.middle) best = *half;
      open.push(*half);
    }
    boxes += 2;
  }
  return {.cost = open.empty() ? std::numeric_limits<double>::infinity() : open.top().cost.lower,
          .boxes = boxes,
          .reached = best.box};
}

}  // namespace haptometer::sim
