#include "sim/tuning/priced_cost.h"

#include <complex>

#include "base/check.h"

namespace haptometer::sim {

namespace {

using Number = Slope<Interval, kBoxAxes>;

struct BoxPhasor {
  Number re, im;
};
Number Norm(const BoxPhasor& z) { return Square(z.re) + Square(z.im); }

Number operator-(const Number& a, const Number& b) { return a + b * Interval::Of(-1); }
Interval Negative(Interval x) { return {-x.upper, -x.lower}; }

}  // namespace

PricedCost::PricedCost(const TuningProblem& problem, const MotorSource& source, bool per_resistance)
    : ranges_(problem, source),
      case_stiffness_(Interval::Of(source.stiffness_n_per_m.real()) -
                      Interval::Of(source.case_mass_kg) * Square(ranges_.omega)),
      passive_(Interval::Of(source.stiffness_n_per_m.imag())),
      free_{Interval::Of(source.free_travel_m.real()), Interval::Of(source.free_travel_m.imag())},
      limit_square_(Square(Interval::Of(problem.mover_limit_m))),
      per_resistance_(per_resistance) {
  HAPTOMETER_CHECK(problem.skin_variation == 0 && limit_square_.upper < HUGE_VAL,
                   "variation {}, limit {}", problem.skin_variation, problem.mover_limit_m);
  const std::complex<double> pushed = source.travel_per_case * source.force_n;
  pushed_ = {Interval::Of(pushed.real()), Interval::Of(pushed.imag())};
}

PricedCost::Number PricedCost::At(const AdapterBox& box, double price) const {
  const auto [G_r, G_i] = pushed_;
  const auto [f_r, f_i] = free_;
  const Interval w = ranges_.omega, q = passive_, two = Interval::Of(2);
  const Interval a = Interval::Of(1) - Interval::Of(price);
  const Interval c = Interval::Of(price) / limit_square_;
  const Interval G2 = Square(G_r) + Square(G_i), f2 = Square(f_r) + Square(f_i);
  const Interval Gf_r = G_r * f_r + G_i * f_i;  // G f*
  const Interval Gf_i = G_i * f_r - G_r * f_i;

  const Number p =
      Between(ranges_.motor_side_mass_kg.lower, ranges_.motor_side_mass_kg.upper, box, 0) *
          Negative(Square(w)) +
      case_stiffness_;
  const Number Ka =
      Between(ranges_.stiffness_n_per_m.lower, ranges_.stiffness_n_per_m.upper, box, 1);
  const Number e =
      Between(ranges_.damping_n_s_per_m.lower, ranges_.damping_n_s_per_m.upper, box, 2) * w;
  const Number Ks =
      Between(ranges_.first.stiffness_n_per_m, ranges_.last.stiffness_n_per_m, box, 3);
  const Number b =
      Between(ranges_.first.damping_n_s_per_m, ranges_.last.damping_n_s_per_m, box, 3) * w;

  const Number k2 = Square(Ka) + Square(e);  // |ka|^2
  const BoxPhasor sum{Ka + p, e + q};        // D1 + ka
  const Number u2 = Norm(sum);               // |U|^2 |ka|^2
  const Number d2 = Square(p) + Square(q);   // |D1|^2
  const BoxPhasor B{sum.re * f_r - sum.im * f_i + G_r, sum.im * f_r + sum.re * f_i + G_i};  // Q ka
  const Number B2 = Norm(B);
  const Number E2 = Square(p * f_r + (G_r - f_i * q)) + Square(p * f_i + (G_i + f_r * q));

  // h1 and h2 times |ka|^2
  const Number h1 = k2 * q + e * d2 + b * u2;
  const Number h2 = b * B2 + k2 * (f2 * q + Gf_i) + e * E2;
  const Number s = u2 * a + B2 * c;                                   // times |ka|^2
  const BoxPhasor turned{(e + b) * p + b * Ka, (e + b) * q + b * e};  // e D1 + b (ka + D1)
  const BoxPhasor V{turned.re * G_r + turned.im * G_i + h1 * f_r,
                    turned.im * G_r - turned.re * G_i - h1 * f_i};
  const BoxPhasor X{k2 * Negative(G_r) - V.im * two, k2 * G_i + V.re * two};  // -G* + 2 j V
  const Number mixed = (k2 * G2 + Norm(X) / k2) * Interval::Of(0.5);
  const Number squares = (Square(h1) * Square(a) + Square(h2) * Square(c)) / k2 + mixed * (a * c);
  const Number best = (k2 * p + Ka * d2) * a + (k2 * Gf_r + Ka * E2 + k2 * p * f2) * c;
  const Number wanted = Ks + best / s;
  const Number off = AboveZero(wanted + Negative(ranges_.most_inertia)) +
                     AboveZero(wanted * Interval::Of(-1) + ranges_.least_inertia);
  const Number cost = squares / s + s / k2 * Square(off);
  return per_resistance_ ? cost / b : cost;
}

BoxCost PricedCost::Over(const AdapterBox& box, double price) const {
  return MeanValueBound(box, At(box, price), At(MiddleOf(box), price).value);
}

}  // namespace haptometer::sim
