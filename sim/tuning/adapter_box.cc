#include "sim/tuning/adapter_box.h"

#include <algorithm>

namespace haptometer::sim {

namespace {

using Number = Slope<Interval, kBoxAxes>;

// lower + (upper - lower) part, with nothing of the range lost to rounding
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

}  // namespace

AdapterCost::AdapterCost(const TuningProblem& problem, const MotorSource& source,
                         bool per_resistance)
    : omega_(Interval::Of(source.omega_rad_per_s)),
      case_stiffness_(Interval::Of(source.stiffness_n_per_m.real()) -
                      Interval::Of(source.case_mass_kg) * Square(omega_)),
      passive_(Interval::Of(source.stiffness_n_per_m.imag())),
      motor_side_mass_kg_(problem.bounds.motor_side_mass_kg),
      stiffness_n_per_m_(problem.bounds.stiffness_n_per_m),
      damping_n_s_per_m_(problem.bounds.damping_n_s_per_m),
      least_inertia_(Interval::Of(problem.bounds.skin_side_mass_kg.lower) * Square(omega_)),
      most_inertia_(Interval::Of(problem.bounds.skin_side_mass_kg.upper) * Square(omega_)),
      first_(SkinOf(problem, problem.bounds.contact_area_m2.lower)),
      last_(SkinOf(problem, problem.bounds.contact_area_m2.upper)),
      variation_(Interval::Of(problem.skin_variation)),
      per_resistance_(per_resistance) {}

AdapterCost::Number AdapterCost::At(const AdapterBox& box) const {
  const Number Ma1 = Between(motor_side_mass_kg_.lower, motor_side_mass_kg_.upper, box, 0);
  const Number Ka = Between(stiffness_n_per_m_.lower, stiffness_n_per_m_.upper, box, 1);
  const Number Ba = Between(damping_n_s_per_m_.lower, damping_n_s_per_m_.upper, box, 2);
  const Number Ks = Between(first_.stiffness_n_per_m, last_.stiffness_n_per_m, box, 3);
  const Number Bs = Between(first_.damping_n_s_per_m, last_.damping_n_s_per_m, box, 3);
  const Interval minus_one = Interval::Of(-1);
  const Number p = Ma1 * (minus_one * Square(omega_)) + case_stiffness_;
  const Number e = Ba * omega_;
  const Number b = Bs * (omega_ * (Interval::Of(1) + variation_));
  const Number u2 = Square(Ka + p) + Square(e + passive_);  // |D1 + ka|^2
  const Number k2 = Square(Ka) + Square(e);                 // |ka|^2
  const Number d2 = Square(p) + Square(passive_);           // |D1|^2
  const Number t2 = u2 / k2;
  const Number t = SquareRoot(t2);
  const Number H = b * t + Number{.value = passive_} / t + e * d2 / (k2 * t);

  // how far Ks + Re Z lies beyond what Ma2 w^2 can be, to either side
  const Number wanted = Ks + (p * k2 + Ka * d2) / u2;
  const Number beyond = wanted + minus_one * most_inertia_;
  const Number short_of = wanted * minus_one + least_inertia_;
  const Number off = AboveZero(beyond) + AboveZero(short_of) + Ks * variation_;
  const Number cost = Square(H) + t2 * Square(off);
  return per_resistance_ ? cost / b : cost;
}

BoxCost AdapterCost::Over(const AdapterBox& box) const {
  // mean value form: cost(middle) + sum of cost'(box) (box - middle)
  const Number natural = At(box);
  const AdapterBox middle = MiddleOf(box);
  Interval mean = At(middle).value;
  BoxCost cost;
  for (std::size_t axis = 0; axis < kBoxAxes; ++axis) {
    const Interval shift = natural.by[axis] * (box[axis] - middle[axis]);
    mean = mean + shift;
    cost.spread[axis] = shift.width();
  }
  cost.lower = std::max({0.0, mean.lower, natural.value.lower});
  return cost;
}

}  // namespace haptometer::sim
