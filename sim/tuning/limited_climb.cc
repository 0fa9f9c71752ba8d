#include "sim/tuning/limited_climb.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "sim/tuning/slope.h"

namespace haptometer::sim {

namespace {

using Number = Slope<double, kCubeAxes>;
using Curvature = Eigen::Matrix<double, kCubeAxes, kCubeAxes>;

constexpr double kKept = 1e-11;

struct Phasor {
  Number re, im;
};
Phasor operator+(const Phasor& a, const Phasor& b) { return {a.re + b.re, a.im + b.im}; }
Phasor operator*(const Phasor& a, const Phasor& b) {
  return {a.re * b.re + a.im * b.im * -1.0, a.re * b.im + a.im * b.re};
}
Phasor operator*(const Phasor& a, std::complex<double> b) {
  return {a.re * b.real() + a.im * -b.imag(), a.im * b.real() + a.re * b.imag()};
}
Number Norm(const Phasor& z) { return z.re * z.re + z.im * z.im; }

Number On(const Range& range, const CubePlace& place, int axis) {
  return Variable<double, kCubeAxes>(place[axis], static_cast<std::size_t>(axis), 1.0) *
             (range.upper - range.lower) +
         range.lower;
}

CubePlace SlopesOf(const Number& number) {
  return CubePlace::Map(number.by.data()) / number.value;  // of the logarithm
}

// f + (rho / 2) max(0, h + lambda / rho)^2 for the lambda and rho of a round
struct Merit {
  double lambda = 1, rho = 10;
  [[nodiscard]] double Pull(const LimitedView& view) const {
    return std::max(0.0, rho * view.excess + lambda);
  }
  [[nodiscard]] double Value(const LimitedView& view) const {
    return view.cost + Pull(view) * Pull(view) / (2 * rho);
  }
  [[nodiscard]] CubePlace Slopes(const LimitedView& view) const {
    return view.cost_slopes + Pull(view) * view.excess_slopes;
  }
};

// second slopes of f + pull h, and what the square adds
Curvature CurvatureAt(const LimitedClimb& climb, const Merit& merit, const CubePlace& place,
                      const LimitedView& here) {
  constexpr double kStep = 1e-6;
  const double pull = merit.Pull(here);
  Curvature bend;
  for (int axis = 0; axis < kCubeAxes; ++axis) {
    const CubePlace step = kStep * CubePlace::Unit(axis);
    const LimitedView after = climb.At(place + step), before = climb.At(place - step);
    bend.col(axis) = (after.cost_slopes - before.cost_slopes +
                      pull * (after.excess_slopes - before.excess_slopes)) /
                     (2 * kStep);
  }
  if (pull > 0) bend += merit.rho * here.excess_slopes * here.excess_slopes.transpose();
  return (bend + bend.transpose()) / 2;
}

// the axes along which the merit may fall: neither fixed nor held by a bound
CubePlace Loose(const CubePlace& free, const CubePlace& place, const CubePlace& slopes) {
  CubePlace loose = free;
  for (int axis = 0; axis < kCubeAxes; ++axis) {
    const bool held =
        (place[axis] <= 0 && slopes[axis] > 0) || (place[axis] >= 1 && slopes[axis] < 0);
    if (held) loose[axis] = 0;
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
CubePlace Descend(const LimitedClimb& climb, const Merit& merit, const CubePlace& free,
                  CubePlace place) {
  constexpr int kMostSteps = 60;
  constexpr double kLeastDamping = 1e-12, kMostDamping = 1e8;
  double damping = 1e-6;
  LimitedView here = climb.At(place);
  for (int count = 0; count < kMostSteps; ++count) {
    const CubePlace slopes = merit.Slopes(here);
    const CubePlace loose = Loose(free, place, slopes);
    if (loose.cwiseProduct(slopes).norm() < 1e-13) return place;
    const Curvature bend = CurvatureAt(climb, merit, place, here);
    bool moved = false;
    for (; damping < kMostDamping && !moved; damping *= 8) {
      const CubePlace next =
          (place + Step(bend, slopes, loose, damping)).cwiseMax(0.0).cwiseMin(1.0);
      const LimitedView there = climb.At(next);
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

AdapterPoint PointOf(const AdapterBounds& bounds, const CubePlace& place) {
  return {.adapter = {.motor_side_mass_kg = bounds.motor_side_mass_kg.At(place[0]),
                      .skin_side_mass_kg = bounds.skin_side_mass_kg.At(place[4]),
                      .stiffness_n_per_m = bounds.stiffness_n_per_m.At(place[1]),
                      .damping_n_s_per_m = bounds.damping_n_s_per_m.At(place[2])},
          .contact_area_m2 = AreaAt(bounds.contact_area_m2, place[3])};
}

LimitedClimb::LimitedClimb(Objective objective, const TuningProblem& problem,
                           const MotorSource& source, const ReceptorField& receptors)
    : objective_(objective), problem_(problem), source_(source), receptors_(receptors) {
  const AdapterBounds& bounds = problem.bounds;
  const auto free = [](const Range& range) { return range.lower < range.upper ? 1.0 : 0.0; };
  free_ << free(bounds.motor_side_mass_kg), free(bounds.stiffness_n_per_m),
      free(bounds.damping_n_s_per_m), problem.fixed_skin ? 0 : free(bounds.contact_area_m2),
      free(bounds.skin_side_mass_kg);
}

double LimitedClimb::LogWeight(double part) const {
  const double area_m2 = AreaAt(problem_.bounds.contact_area_m2, part);
  return 2 * std::log(StimulatedReceptors(receptors_, ContactRadius(area_m2)));
}

LimitedView LimitedClimb::At(const CubePlace& place) const {
  const AdapterBounds& bounds = problem_.bounds;
  const double w = source_.omega_rad_per_s;
  const Skin first = SkinOf(problem_, bounds.contact_area_m2.lower);
  const Skin last = SkinOf(problem_, bounds.contact_area_m2.upper);
  const Number p = (On(bounds.motor_side_mass_kg, place, 0) + source_.case_mass_kg) * (-w * w) +
                   source_.stiffness_n_per_m.real();
  const Phasor D1{p, {.value = source_.stiffness_n_per_m.imag()}};
  const Phasor ka{On(bounds.stiffness_n_per_m, place, 1),
                  On(bounds.damping_n_s_per_m, place, 2) * w};
  const Number b = On({first.damping_n_s_per_m, last.damping_n_s_per_m}, place, 3) * w;
  const Phasor D2{On({first.stiffness_n_per_m, last.stiffness_n_per_m}, place, 3) +
                      On(bounds.skin_side_mass_kg, place, 4) * (-w * w),
                  b};

  // Xs = Fc ka / N, travel = (G (D2 + ka) + f N) / N
  const Phasor N = D1 * D2 + ka * (D1 + D2);
  const Phasor M =
      (D2 + ka) * (source_.travel_per_case * source_.force_n) + N * source_.free_travel_m;
  const Number N2 = Norm(N), M2 = Norm(M), k2 = Norm(ka);
  LimitedView view{.cost = std::log(N2.value / k2.value),
                   .excess = std::log(M2.value / N2.value) - 2 * std::log(problem_.mover_limit_m),
                   .cost_slopes = SlopesOf(N2) - SlopesOf(k2),
                   .excess_slopes = SlopesOf(M2) - SlopesOf(N2)};
  if (objective_ == Objective::kSkinPower) {
    view.cost -= std::log(b.value);
    view.cost_slopes -= SlopesOf(b);
  } else if (objective_ == Objective::kStimulus) {
    constexpr double kStep = 1e-5;
    const double before = std::clamp(place[3] - kStep, 0.0, 1.0);
    const double after = std::clamp(place[3] + kStep, 0.0, 1.0);
    view.cost -= LogWeight(place[3]);
    if (after > before)
      view.cost_slopes[3] -= (LogWeight(after) - LogWeight(before)) / (after - before);
  }
  return view;
}

LimitedSummit LimitedClimb::From(const CubePlace& start) const {
  constexpr int kMostRounds = 40;
  Merit merit;
  LimitedSummit summit{.place = start};
  double before = HUGE_VAL;
  for (int round = 0; round < kMostRounds; ++round) {
    summit.place = Descend(*this, merit, free_, summit.place);
    const LimitedView view = At(summit.place);
    const double miss = std::abs(std::max(view.excess, -merit.lambda / merit.rho));
    merit.lambda = merit.Pull(view);
    summit.cost = view.cost;
    summit.kept = view.excess <= kKept;
    if (miss < kKept / 10) break;
    if (miss > before / 8) merit.rho *= 4;
    before = miss;
  }
  summit.price = merit.lambda;
  return summit;
}

}  // namespace haptometer::sim
