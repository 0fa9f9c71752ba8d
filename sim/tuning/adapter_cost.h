#pragma once

#include <array>
#include <cstddef>

#include "sim/linear/motor_source.h"
#include "sim/tuning/interval.h"
#include "sim/tuning/tuning_problem.h"

namespace haptometer::sim {

/// The four numbers that are left when Ma2 takes its best value, each as its part of the way
/// between its bounds: Ma1, Ka, Ba, and the area by AreaAt().
inline constexpr std::size_t kBoxAxes = 4;
using AdapterBox = std::array<Interval, kBoxAxes>;

/// Bounds of the cost of every adapter within a box.
struct BoxCost {
  double lower = 0;                       ///< no adapter of the box costs less
  double middle = 0;                      ///< the adapter in its middle costs no more
  std::array<double, kBoxAxes> spread{};  ///< by which each axis widens the bound, to choose a cut
  /// Of an axis along which the cost rises all over the box +1, where it falls -1, else 0.
  std::array<int, kBoxAxes> trend{};
};

/// The adapters of a problem's bounds for interval arithmetic.
struct AdapterRanges {
  explicit AdapterRanges(const TuningProblem& problem, const MotorSource& source);

  Interval omega;  ///< w
  Range motor_side_mass_kg, stiffness_n_per_m, damping_n_s_per_m;
  Interval least_inertia, most_inertia;  ///< of Ma2 w^2
  Skin first, last;                      ///< at the ends of the area
};

/// lower + (upper - lower) x the box's axis, with nothing of the range lost to rounding.
[[nodiscard]] Slope<Interval, kBoxAxes> Between(double lower, double upper, const AdapterBox& box,
                                                std::size_t axis);

/// The box's middle as a box.
[[nodiscard]] AdapterBox MiddleOf(const AdapterBox& box);

/// The mean value form f(middle) + sum of f'(box) (box - middle), or f(box) where that is higher;
/// `natural` is f with its slopes over the box (of its value the lower end alone counts), `middle`
/// f at its middle.
[[nodiscard]] BoxCost MeanValueBound(const AdapterBox& box,
                                     const Slope<Interval, kBoxAxes>& natural,
                                     const Interval& middle);

/// The cost of an adapter with the best Ma2: |Fc / Xs|^2, in (N/m)^2; the less, the more the skin
/// moves. Of the skin that moves least, where skins vary. Divided by w Bs where `per_resistance`,
/// so that the least cost is the most power. Where the mover's travel |X| has a price m it is
///
///   (1 - m) |Fc / Xs|^2 + m |Fc / Xs|^2 |X|^2 / T^2,       0 <= m < 1,
///
/// the cost itself where the travel is the limit T and no more than it where the travel is less. So
/// no adapter that keeps to the limit costs less than the least of this, whatever m (weak duality);
/// with the right m the least of it is the answer, where the duality has no gap.
///
/// With the letters of sim/tuning/adapter_objective.h, D2 = Ks + j b - y, y = Ma2 w^2, f = F/d1,
///
///   Fc / Xs = D2 + D1 (1 + D2/ka),      Fc X / Xs = f (D2 - (Mv + Mc + Ma1) w^2 (1 + D2/ka)):
///
/// to a mover whose travel is given the case is no spring, but a mass. Both are the same linear
/// function of D1 and of that mass's -M w^2 = D1 - (delta + j Im kc), delta = Re kc + Mv w^2, so
/// that their weighed squares are those of one source between the two, with a = 1 - m, c = m |f|^2
/// / T^2, s = a + c,
///
///   s (|D2 + D (1 + D2/ka)|^2 + k^2 |1 + D2/ka|^2),
///   D = p + j q,   p = Re D1 - c delta / s,   q = a Im kc / s,
///   k^2 = a c (delta^2 + (Im kc)^2) / s^2.
///
/// That is a square in y, whose best value leaves four numbers and
///
///   s (b^2 S + 2 b h + (h^2 + k^2 + g^2) / S),
///   S = (|ka + D|^2 + k^2) / |ka|^2,   h = q + e (|D|^2 + k^2) / |ka|^2,
///   g = S (Ks - y) + p + Ka (|D|^2 + k^2) / |ka|^2,
///
/// g = 0 where Ma2 may be best, else with y at the nearer of its ends. With a skin_variation v,
/// which has no price, |g| is larger by S v Ks and b is that of the largest Bs. Divided by b the
/// cost is that of b = 1 and b S in place of S.
class AdapterCost {
 public:
  /// A price above 0 needs a finite mover_limit_m and a skin_variation of 0.
  AdapterCost(const TuningProblem& problem, const MotorSource& source, bool per_resistance,
              double price = 0);

  /// A lower bound over the box, the higher of two. The mean value form; and that of the ranges of
  /// S, h, b and |g| over the box: the cost is convex over S and rises with the others, so that its
  /// least over those ranges is known, 2 b (h + sqrt(h^2 + k^2)) where g is 0 and S may be what is
  /// best. The ridge is where S keeps that value: boxes as long as the ridge have a tight bound.
  [[nodiscard]] BoxCost Over(const AdapterBox& box) const;

 private:
  using Number = Slope<Interval, kBoxAxes>;
  struct Terms {
    Number S, h, b, g;  // of g its size
  };
  [[nodiscard]] Terms TermsOver(const AdapterBox& box) const;
  [[nodiscard]] Interval Sum(const Terms& at) const;
  [[nodiscard]] Interval SlopeBy(const Terms& over, std::size_t axis) const;
  [[nodiscard]] double LeastOf(const Terms& over) const;

  AdapterRanges ranges_;
  bool per_resistance_;
  Interval variation_;         // v, of the skin
  Interval scale_;             // s
  Interval real_, imaginary_;  // p of a case without masses, and q
  Interval apart_;             // k^2
};

}  // namespace haptometer::sim
