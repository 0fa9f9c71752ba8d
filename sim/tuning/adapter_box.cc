#include "sim/tuning/adapter_box.h"

#include <algorithm>

namespace haptometer::sim {

namespace {
using Number = Slope<Interval, kBoxAxes>;
}  // namespace

AdapterRanges::AdapterRanges(const TuningProblem& problem, const MotorSource& source)
    : omega(Interval::Of(source.omega_rad_per_s)),
      motor_side_mass_kg(problem.bounds.motor_side_mass_kg),
      stiffness_n_per_m(problem.bounds.stiffness_n_per_m),
      damping_n_s_per_m(problem.bounds.damping_n_s_per_m),
      least_inertia(Interval::Of(problem.bounds.skin_side_mass_kg.lower) * Square(omega)),
      most_inertia(Interval::Of(problem.bounds.skin_side_mass_kg.upper) * Square(omega)),
      first(SkinOf(problem, problem.bounds.contact_area_m2.lower)),
      last(SkinOf(problem, problem.bounds.contact_area_m2.upper)) {}

Number Between(double lower, double upper, const AdapterBox& box, std::size_t axis) {
  const Interval low = Interval::Of(lower);
  return Variable<Interval, kBoxAxes>(box[axis], axis, Interval::Of(1)) *
             (Interval::Of(upper) - low) +
         low;
}

AdapterBox MiddleOf(const AdapterBox& box) {
  AdapterBox middle;
  for (std::size_t axis = 0; axis < kBoxAxes; ++axis) {
    middle[axis] = Interval::Of(box[axis].middle());
  }
  return middle;
}

BoxCost MeanValueBound(const AdapterBox& box, const Number& natural, const Interval& middle) {
  Interval mean = middle;
  BoxCost cost{.middle = middle.upper};
  for (std::size_t axis = 0; axis < kBoxAxes; ++axis) {
    const Interval shift = natural.by[axis] * (box[axis] - Interval::Of(box[axis].middle()));
    mean = mean + shift;
    cost.spread[axis] = shift.width();
    cost.trend[axis] = natural.by[axis].lower > 0 ? 1 : natural.by[axis].upper < 0 ? -1 : 0;
  }
  cost.lower = std::max({0.0, mean.lower, natural.value.lower});
  return cost;
}

}  // namespace haptometer::sim
