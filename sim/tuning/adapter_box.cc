#include "sim/tuning/adapter_box.h"

#include <algorithm>

#include "sim/tuning/slope.h"

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

// how far the interval lies from [below, above], at least
double Distance(Interval wanted, double below, double above) {
  return std::max({0.0, below - wanted.upper, wanted.lower - above});
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
      per_resistance_(per_resistance) {}

BoxCost AdapterCost::Over(const AdapterBox& box) const {
  // H, and the values that the second square needs
  struct Parts {
    Number resistance;                 // H, over sqrt(b) where per_resistance_
    Interval through, wanted_inertia;  // t^2 (over b), Ks + Re Z
  };
  const auto parts_over = [this](const AdapterBox& at) {
    const Number Ma1 = Between(motor_side_mass_kg_.lower, motor_side_mass_kg_.upper, at, 0);
    const Number Ka = Between(stiffness_n_per_m_.lower, stiffness_n_per_m_.upper, at, 1);
    const Number Ba = Between(damping_n_s_per_m_.lower, damping_n_s_per_m_.upper, at, 2);
    const Number Ks = Between(first_.stiffness_n_per_m, last_.stiffness_n_per_m, at, 3);
    const Number Bs = Between(first_.damping_n_s_per_m, last_.damping_n_s_per_m, at, 3);
    const Interval minus_square = Interval::Of(0) - Square(omega_);
    const Number p = Ma1 * minus_square + case_stiffness_;
    const Number e = Ba * omega_;
    const Number b = Bs * omega_;
    const Number u2 = Square(Ka + p) + Square(e + passive_);  // |D1 + ka|^2
    const Number k2 = Square(Ka) + Square(e);                 // |ka|^2
    const Number d2 = Square(p) + Square(passive_);           // |D1|^2
    const Number t = SquareRoot(u2 / k2);
    const Number q_over_t = Number{.value = passive_} / t;
    Parts parts{.resistance = b * t + q_over_t + e * d2 / (k2 * t),
                .through = u2.value / k2.value,
                .wanted_inertia = Ks.value + (p * k2 + Ka * d2).value / u2.value};
    if (per_resistance_) {
      parts.resistance = parts.resistance / SquareRoot(b);
      parts.through = parts.through / b.value;
    }
    return parts;
  };
  const Parts parts = parts_over(box);
  const AdapterBox middle = MiddleOf(box);

  // mean value form: H(middle) + sum of H'(box) (box - middle)
  Interval mean = parts_over(middle).resistance.value;
  BoxCost cost;
  for (std::size_t axis = 0; axis < kBoxAxes; ++axis) {
    const Interval shift = parts.resistance.by[axis] * (box[axis] - middle[axis]);
    mean = mean + shift;
    cost.spread[axis] = shift.width();
  }
  const double H = std::max({0.0, mean.lower, parts.resistance.value.lower});
  const double off = Distance(parts.wanted_inertia, least_inertia_.lower, most_inertia_.upper);
  const Interval squares =
      Square(Interval::Of(H)) + Square(Interval::Of(off)) * Interval::Of(parts.through.lower);
  cost.lower = std::max(0.0, squares.lower);
  return cost;
}

}  // namespace haptometer::sim
