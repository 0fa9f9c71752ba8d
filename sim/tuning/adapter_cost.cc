#include "sim/tuning/adapter_cost.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

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
    // f'(box) (box - middle), the axis's share of the mean value form
    const Interval shift = natural.by[axis] * (box[axis] - Interval::Of(box[axis].middle()));
    mean = mean + shift;
    cost.spread[axis] = shift.width();
    // a slope of one sign over the whole box
    cost.trend[axis] = natural.by[axis].lower > 0 ? 1 : natural.by[axis].upper < 0 ? -1 : 0;
  }
  // the higher of both bounds; a cost is never negative
  cost.lower = std::max({0.0, mean.lower, natural.value.lower});
  return cost;
}

namespace {

Interval Negative(Interval x) { return {-x.upper, -x.lower}; }

// the number over the box with its range cut to that of its mean value form
void Narrow(const AdapterBox& box, const Interval& middle, Number& over) {
  Interval mean = middle;
  for (std::size_t axis = 0; axis < kBoxAxes; ++axis) {
    mean = mean + over.by[axis] * (box[axis] - Interval::Of(box[axis].middle()));
  }
  over.value = {std::max(over.value.lower, mean.lower), std::min(over.value.upper, mean.upper)};
}

}  // namespace

AdapterCost::AdapterCost(const TuningProblem& problem, const MotorSource& source,
                         bool per_resistance, double price)
    : ranges_(problem, source),
      per_resistance_(per_resistance),
      variation_(Interval::Of(problem.skin_variation)),
      scale_(Interval::Of(1)),
      imaginary_(Interval::Of(source.stiffness_n_per_m.imag())) {
  const Interval square = Square(ranges_.omega);
  const Interval stiffness = Interval::Of(source.stiffness_n_per_m.real());
  // Re kc - Mc w^2; Ma1 is added over the box
  real_ = stiffness - Interval::Of(source.case_mass_kg) * square;
  if (price == 0) return;
  HAPTOMETER_CHECK(
      price > 0 && price < 1 && problem.skin_variation == 0 && std::isfinite(problem.mover_limit_m),
      "price {}, variation {}, limit {}", price, problem.skin_variation, problem.mover_limit_m);
  // |f|^2 = |F / d1|^2, the mover's travel with the case at rest
  const Interval free = Square(Interval::Of(source.free_travel_m.real())) +
                        Square(Interval::Of(source.free_travel_m.imag()));
  // a, c, delta, s, k^2, p and q of the header
  const Interval a = Interval::Of(1) - Interval::Of(price);
  const Interval c = Interval::Of(price) * free / Square(Interval::Of(problem.mover_limit_m));
  const Interval delta = stiffness + Interval::Of(problem.actuator.moving_mass_kg) * square;
  scale_ = a + c;
  apart_ = a * c * (Square(delta) + Square(imaginary_)) / Square(scale_);
  real_ = real_ - c * delta / scale_;
  imaginary_ = a * imaginary_ / scale_;
}

AdapterCost::Terms AdapterCost::TermsOver(const AdapterBox& box) const {
  // p, Ka, e, Ks and b over the box, each linear in its axis, with slopes
  const Interval w = ranges_.omega;
  const Number p =
      Between(ranges_.motor_side_mass_kg.lower, ranges_.motor_side_mass_kg.upper, box, 0) *
          Negative(Square(w)) +
      real_;
  const Number Ka =
      Between(ranges_.stiffness_n_per_m.lower, ranges_.stiffness_n_per_m.upper, box, 1);
  const Number e =
      Between(ranges_.damping_n_s_per_m.lower, ranges_.damping_n_s_per_m.upper, box, 2) * w;
  const Number Ks =
      Between(ranges_.first.stiffness_n_per_m, ranges_.last.stiffness_n_per_m, box, 3);
  const Number b =
      Between(ranges_.first.damping_n_s_per_m, ranges_.last.damping_n_s_per_m, box, 3) *
      (w * (Interval::Of(1) + variation_));
  const Number k2 = Square(Ka) + Square(e);                            // |ka|^2
  const Number d2 = Square(p) + (Square(imaginary_) + apart_);         // |D|^2 + k^2
  const Number u2 = Square(Ka + p) + Square(e + imaginary_) + apart_;  // S |ka|^2

  // S times how far Ma2 w^2 is wanted beyond what it can be, to either side
  const Number S = u2 / k2;
  // g = S (Ks - y) + p + Ka (|D|^2 + k^2) / |ka|^2 at both ends of y = Ma2 w^2; 0 between them
  const Number seen = p + Ka * d2 / k2;
  const Number beyond =
      AboveZero(seen + S * (Ks + Negative(ranges_.most_inertia))) +
      AboveZero((seen + S * (Ks + Negative(ranges_.least_inertia))) * Interval::Of(-1)) +
      S * Ks * variation_;
  const Number h = e * d2 / k2 + imaginary_;
  // divided by b the cost is that of b = 1 and b S in place of S
  if (!per_resistance_) return {.S = S, .h = h, .b = b, .g = beyond};
  return {.S = S * b, .h = h, .b = {.value = Interval::Of(1)}, .g = beyond};
}

// b^2 S + 2 b h + (h^2 + k^2 + g^2) / S
Interval AdapterCost::Sum(const Terms& at) const {
  const Interval S = at.S.value, h = at.h.value, b = at.b.value;
  return Square(b) * S + Interval::Of(2) * b * h + (Square(h) + apart_ + Square(at.g.value)) / S;
}

// by the chain rule: the slope by S, small on the ridge, is no difference of larger terms
Interval AdapterCost::SlopeBy(const Terms& over, std::size_t axis) const {
  const Interval S = over.S.value, h = over.h.value, b = over.b.value, g = over.g.value;
  const Interval two = Interval::Of(2);
  const Interval by_S = Square(b) - (Square(h) + apart_ + Square(g)) / Square(S);
  return by_S * over.S.by[axis] + two * (b + h / S) * over.h.by[axis] +
         two * (b * S + h) * over.b.by[axis] + two * g / S * over.g.by[axis];
}

// the least of Sum() over the terms' ranges
double AdapterCost::LeastOf(const Terms& over) const {
  // the cost rises with h, b and g, so that their lower ends count
  const Interval h = Interval::Of(over.h.value.lower), b = Interval::Of(over.b.value.lower);
  const Interval rising = Square(b);
  const Interval falling =
      Square(h) + apart_ + Square(Interval::Of(std::max(0.0, over.g.value.lower)));
  const auto at = [&](double S) { return rising * Interval::Of(S) + falling / Interval::Of(S); };
  // a bound for any S; a larger one where the best S certainly lies outside of the range
  Interval least = Interval::Of(2) * SquareRoot(rising * falling);
  const double low = over.S.value.lower, high = over.S.value.upper;
  if ((rising * Square(Interval::Of(low)) - falling).lower > 0) least = at(low);
  if ((rising * Square(Interval::Of(high)) - falling).upper < 0) least = at(high);
  return (least + Interval::Of(2) * b * h).lower;
}

BoxCost AdapterCost::Over(const AdapterBox& box) const {
  const Terms middle = TermsOver(MiddleOf(box));
  // narrower ranges before the terms are combined, where each range counts several times
  Terms over = TermsOver(box);
  Narrow(box, middle.S.value, over.S);
  Narrow(box, middle.h.value, over.h);
  Narrow(box, middle.g.value, over.g);
  Number natural{.value = {LeastOf(over), Sum(over).upper}};
  for (std::size_t axis = 0; axis < kBoxAxes; ++axis) natural.by[axis] = SlopeBy(over, axis);
  return MeanValueBound(box, natural * scale_, Sum(middle) * scale_);
}

}  // namespace haptometer::sim
