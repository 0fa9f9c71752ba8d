#pragma once

#include "sim/tuning/adapter_box.h"

namespace haptometer::sim {

/// Lower bounds of the cost |Fc / Xs|^2 where the mover's travel |X| has a price: of
///
///   (1 - m) |Fc / Xs|^2 + m |Fc / Xs|^2 |X|^2 / T^2,       0 <= m <= 1,
///
/// which is the cost where the travel is the limit T and no more than it where the travel is less.
/// So no adapter that keeps to the limit costs less than the least of this, whatever m (weak
/// duality); with the right m the least of it is the answer, where the duality has no gap.
///
/// Both terms are squares of numbers that are linear in y = Ma2 w^2, |d - U y|^2 and |p - Q y|^2
/// (sim/tuning/travel_limit.h), so the best y is known and four numbers are left. With a = 1 - m,
/// c = m / T^2, Lagrange's identity leaves sums of squares, nothing to cancel in the first two:
///
///   (a^2 h1^2 + c^2 h2^2 + a c (|G|^2 + 2 |V|^2 + 2 Im(G V))) / s  +  s off^2,
///   s = a |U|^2 + c |Q|^2,                           off: from (y's best) to what Ma2 can be,
///   h1 = Im(d U*) = Im kc + e |D1|^2 / |ka|^2 + b |U|^2,
///   h2 = Im(p Q*) = b |Q|^2 + |f|^2 Im kc - Im(f G*) + e |G + f D1|^2 / |ka|^2,
///   V = G* (e D1 + b (ka + D1)) / |ka|^2 + f* h1,
///   y's best = Ks + (a Re(D1 U*) + c Re((G + f D1) Q*)) / s,
///
/// G = (1 - k1/d1) Fc, f = F/d1, U = 1 + D1/ka, Q = G/ka + f U, D1, ka, b and e as in
/// sim/tuning/adapter_objective.h.
class PricedCost {
 public:
  /// The problem must have a finite mover_limit_m and no skin_variation. Divided by w Bs where
  /// `per_resistance`.
  PricedCost(const TuningProblem& problem, const MotorSource& source, bool per_resistance);

  /// As AdapterCost::Over, with the price m.
  [[nodiscard]] BoxCost Over(const AdapterBox& box, double price) const;

 private:
  using Number = Slope<Interval, kBoxAxes>;
  struct Plane {
    Interval re, im;
  };
  [[nodiscard]] Number At(const AdapterBox& box, double price) const;

  AdapterRanges ranges_;
  Interval case_stiffness_, passive_;  // Re kc - Mc w^2 and Im kc
  Plane pushed_, free_;                // G and f
  Interval limit_square_;
  bool per_resistance_;
};

}  // namespace haptometer::sim
