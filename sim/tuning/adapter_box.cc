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
  BoxCost cost;
  for (std::size_t axis = 0; axis < kBoxAxes; ++axis) {
    const Interval shift = natural.by[axis] * (box[axis] - Interval::Of(box[axis].middle()));
    mean = mean + shift;
    cost.spread[axis] = shift.width();
    cost.trend[axis] = natural.by[axis].lower > 0 ? 1 : natural.by[axis].upper < 0 ? -1 : 0;
  }
  cost.lower = std::max({0.0, mean.lower, natural.value.lower});
  return cost;
}

AdapterCost::AdapterCost(const TuningProblem& problem, const MotorSource& source,
                         bool per_resistance)
    : ranges_(problem, source),
      case_stiffness_(Interval::Of(source.stiffness_n_per_m.real()) -
                      Interval::Of(source.case_mass_kg) * Square(ranges_.omega)),
      passive_(Interval::Of(source.stiffness_n_per_m.imag())),
      variation_(Interval::Of(problem.skin_variation)),
      per_resistance_(per_resistance) {}

AdapterCost::Number AdapterCost::At(const AdapterBox& box) const {
  const Number Ma1 =
      Between(ranges_.motor_side_mass_kg.lower, ranges_.motor_side_mass_kg.upper, box, 0);
  const Number Ka =
      Between(ranges_.stiffness_n_per_m.lower, ranges_.stiffness_n_per_m.upper, box, 1);
  const Number Ba =
      Between(ranges_.damping_n_s_per_m.lower, ranges_.damping_n_s_per_m.upper, box, 2);
  const Number Ks =
      Between(ranges_.first.stiffness_n_per_m, ranges_.last.stiffness_n_per_m, box, 3);
  const Number Bs =
      Between(ranges_.first.damping_n_s_per_m, ranges_.last.damping_n_s_per_m, box, 3);
  const Interval minus_one = Interval::Of(-1);
  const Number p = Ma1 * (minus_one * Square(ranges_.omega)) + case_stiffness_;
  const Number e = Ba * ranges_.omega;
  const Number b = Bs * (ranges_.omega * (Interval::Of(1) + variation_));
  const Number u2 = Square(Ka + p) + Square(e + passive_);  // |D1 + ka|^2
  const Number k2 = Square(Ka) + Square(e);                 // |ka|^2
  const Number d2 = Square(p) + Square(passive_);           // |D1|^2
  const Number t2 = u2 / k2;
  const Number t = SquareRoot(t2);
  const Number H = b * t + Number{.value = passive_} / t + e * d2 / (k2 * t);

  // how far Ks + Re Z lies beyond what Ma2 w^2 can be, to either side
  const Number wanted = Ks + (p * k2 + Ka * d2) / u2;
  const Number beyond = wanted + minus_one * ranges_.most_inertia;
  const Number short_of = wanted * minus_one + ranges_.least_inertia;
  const Number off = AboveZero(beyond) + AboveZero(short_of) + Ks * variation_;
  const Number cost = Square(H) + t2 * Square(off);
  return per_resistance_ ? cost / b : cost;
}

BoxCost AdapterCost::Over(const AdapterBox& box) const {
  return MeanValueBound(box, At(box), At(MiddleOf(box)).value);
}

}  // namespace haptometer::sim
