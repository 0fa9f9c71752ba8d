#include "sim/tuning/bounded_climb.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace haptometer::sim {

namespace {

using CubeView = std::function<LimitedView(const CubePlace&)>;
using Curvature = Eigen::Matrix<double, kCubeAxes, kCubeAxes>;

struct CubeBounds {
  CubePlace lower, upper;
};

// f + (rho / 2) max(0, h + lambda / rho)^2 for the lambda and rho of a round
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

// second slopes of f + pull h, and what the square adds
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
    system(axis, axis) += loose[axis] > 0 ? damping * (1 + std::abs(bend(axis, axis))) : 1;
  }
  const Eigen::LDLT<Curvature> factors(system);
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
    damping = std::max(kLeastDamping, damping / 64);
  }
  return place;
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
    const double miss = std::abs(std::max(at.excess, -merit.lambda / merit.rho));
    merit.lambda = merit.Pull(at);
    summit.cost = at.cost;
    summit.kept = at.excess <= kKeptLimit;
    if (miss < kKeptLimit / 10) break;
    if (miss > before / 8) merit.rho *= 4;
    before = miss;
  }
  summit.price = merit.lambda;
  return summit;
}

}  // namespace haptometer::sim
