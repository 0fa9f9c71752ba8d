#include "sim/tuning/search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <queue>
#include <utility>

namespace haptometer::sim {
namespace {

using CubeView = std::function<LimitedView(const CubePlace&)>;
using Curvature = Eigen::Matrix<double, kCubeAxes, kCubeAxes>;

struct CubeBounds {
  CubePlace lower, upper;
};

// augmented Lagrangian f + (rho / 2) max(0, h + lambda / rho)^2 of a round
struct LimitedMerit {
  double lambda = 1, rho = 10;
  [[nodiscard]] double Pull(const LimitedView& at) const {
    return std::max(0.0, rho * at.excess + lambda);
  }
  [[nodiscard]] double Value(const LimitedView& at) const {
    return at.cost + Pull(at) * Pull(at) / (2 * rho);
  }
  [[nodiscard]] CubePlace Slopes(const LimitedView& at) const {
    return at.cost_slopes + Pull(at) * at.excess_slopes;
  }
};

// second derivatives of f + pull h by central differences, and rho h' h'^T of the square
Curvature CurvatureAt(const CubeView& view, const LimitedMerit& merit, const CubePlace& place,
                      const LimitedView& here) {
  constexpr double kStep = 1e-6;
  const double pull = merit.Pull(here);
  Curvature bend;
  for (int axis = 0; axis < kCubeAxes; ++axis) {
    const CubePlace step = kStep * CubePlace::Unit(axis);
    const LimitedView after = view(place + step), before = view(place - step);
    bend.col(axis) = (after.cost_slopes - before.cost_slopes +
                      pull * (after.excess_slopes - before.excess_slopes)) /
                     (2 * kStep);
  }
  if (pull > 0) bend += merit.rho * here.excess_slopes * here.excess_slopes.transpose();
  return (bend + bend.transpose()) / 2;
}

// the axes along which the merit may fall: neither fixed nor held by a bound
CubePlace Loose(const CubeBounds& bounds, const CubePlace& place, const CubePlace& slopes) {
  CubePlace loose = CubePlace::Ones();
  for (int axis = 0; axis < kCubeAxes; ++axis) {
    const bool held = (place[axis] <= bounds.lower[axis] && slopes[axis] > 0) ||
                      (place[axis] >= bounds.upper[axis] && slopes[axis] < 0);
    if (held || bounds.lower[axis] == bounds.upper[axis]) loose[axis] = 0;
  }
  return loose;
}

// the Newton step along the loose axes, damped by `damping` times the diagonal's size
CubePlace Step(const Curvature& bend, const CubePlace& slopes, const CubePlace& loose,
               double damping) {
  Curvature system = loose.asDiagonal() * bend * loose.asDiagonal();
  for (int axis = 0; axis < kCubeAxes; ++axis) {
    // a held axis has 1 on its diagonal and no slope, so it does not move
    system(axis, axis) += loose[axis] > 0 ? damping * (1 + std::abs(bend(axis, axis))) : 1;
  }
  const Eigen::LDLT<Curvature> factors(system);
  // not positive definite: no descent, more damping is needed
  if (!factors.isPositive()) return CubePlace::Zero();
  return -factors.solve(loose.cwiseProduct(slopes));
}

// the least merit that damped Newton steps find
CubePlace Descend(const CubeView& view, const LimitedMerit& merit, const CubeBounds& bounds,
                  CubePlace place) {
  constexpr int kMostSteps = 60;
  constexpr double kLeastDamping = 1e-12, kMostDamping = 1e8;
  double damping = 1e-6;
  LimitedView here = view(place);
  for (int count = 0; count < kMostSteps; ++count) {
    const CubePlace slopes = merit.Slopes(here);
    const CubePlace loose = Loose(bounds, place, slopes);
    if (loose.cwiseProduct(slopes).norm() < 1e-13) return place;
    const Curvature bend = CurvatureAt(view, merit, place, here);
    bool moved = false;
    // more damping until the merit falls
    for (; damping < kMostDamping && !moved; damping *= 8) {
      const CubePlace next = (place + Step(bend, slopes, loose, damping))
                                 .cwiseMax(bounds.lower)
                                 .cwiseMin(bounds.upper);
      const LimitedView there = view(next);
      if (!(merit.Value(there) < merit.Value(here))) continue;
      place = next;
      here = there;
      moved = true;
    }
    if (!moved) return place;
    // less damping after a step that succeeded
    damping = std::max(kLeastDamping, damping / 64);
  }
  return place;
}

// lambda of f' + lambda h' = 0 and h = 0 after a Newton step of both along the loose axes: where
// the merit falls by less than its rounding, the slopes still tell the place, and so lambda, apart
double PriceAt(const CubeView& view, const LimitedMerit& merit, const CubeBounds& bounds,
               const CubePlace& place) {
  const LimitedView here = view(place);
  if (!(merit.lambda > 0)) return 0;
  const CubePlace loose = Loose(bounds, place, merit.Slopes(here));
  const CubePlace limit = loose.cwiseProduct(here.excess_slopes);
  // with H = f'' + lambda h'' + rho h' h'^T: H step = -(f' + rho h h' + lambda h'), h' step = -h
  const Curvature bend = CurvatureAt(view, merit, place, here);
  const CubePlace with_limit = -Step(bend, limit, loose, 0);
  const CubePlace with_cost =
      -Step(bend, here.cost_slopes + merit.rho * here.excess * here.excess_slopes, loose, 0);
  const double price = (here.excess - limit.dot(with_cost)) / limit.dot(with_limit);
  return std::isfinite(price) && price > 0 ? price : merit.lambda;
}

}  // namespace

LimitedSummit ClimbWithinBounds(const CubeView& view, const CubePlace& lower,
                                const CubePlace& upper, const CubePlace& start) {
  constexpr int kMostRounds = 40;
  LimitedMerit merit;
  LimitedSummit summit{.place = start};
  double before = HUGE_VAL;
  for (int round = 0; round < kMostRounds; ++round) {
    summit.place = Descend(view, merit, {.lower = lower, .upper = upper}, summit.place);
    const LimitedView at = view(summit.place);
    // how far the limit is exceeded, or the pull differs from 0 with room left
    const double miss = std::abs(std::max(at.excess, -merit.lambda / merit.rho));
    // the multiplier of the next round, max(0, lambda + rho h)
    merit.lambda = merit.Pull(at);
    summit.cost = at.cost;
    summit.kept = at.excess <= kKeptLimit;
    if (miss < kKeptLimit / 10) break;
    // too slow: a harder penalty
    if (miss > before / 8) merit.rho *= 4;
    before = miss;
  }
  // the last lambda is the price of the limit: decrease of the cost per unit of its logarithm
  summit.price = PriceAt(view, merit, {.lower = lower, .upper = upper}, summit.place);
  return summit;
}

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

// a slope of one sign puts the least at the lower or the upper end of the axis: on the cube's face
// the box is flattened to it, elsewhere a neighbouring box has it
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
  // boxes with a bound above this need no splitting
  const auto open_by = [&] { return std::min(enough, (1 - kSettled) * best.cost.middle); };
  while (!open.empty() && open.top().cost.lower < open_by() && boxes < most_boxes) {
    const OpenBox first = open.top();
    open.pop();
    // halve the axis that widens the bound most
    const auto widest = std::ranges::max_element(first.cost.spread);
    const auto axis = static_cast<std::size_t>(widest - first.cost.spread.begin());
    OpenBox lower{.box = first.box};
    OpenBox upper{.box = first.box};
    lower.box[axis].upper = upper.box[axis].lower = first.box[axis].middle();
    for (OpenBox* half : {&lower, &upper}) {
      if (!Bound(over, *half)) continue;
      // the middle is an adapter: its cost is an upper bound of the least
      if (half->cost.middle < best.cost.middle) best = *half;
      open.push(*half);
    }
    boxes += 2;
  }
  // the lowest bound among the boxes not yet split
  return {.cost = open.empty() ? std::numeric_limits<double>::infinity() : open.top().cost.lower,
          .boxes = boxes,
          .reached = best.box};
}

}  // namespace haptometer::sim
