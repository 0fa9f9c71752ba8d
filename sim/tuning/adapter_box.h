#pragma once

#include <array>
#include <cstddef>

#include "sim/tuning/adapter_bounds.h"
#include "sim/tuning/interval.h"
#include "sim/tuning/motor_source.h"
#include "sim/tuning/slope.h"

namespace haptometer::sim {

/// The four numbers that are left when Ma2 takes its best value, each as its part of the way
/// between its bounds: Ma1, Ka, Ba, and the area by AreaAt().
inline constexpr std::size_t kBoxAxes = 4;
using AdapterBox = std::array<Interval, kBoxAxes>;

/// Bounds of the cost of every adapter within a box.
struct BoxCost {
  double lower = 0;                       ///< no adapter of the box costs less
  std::array<double, kBoxAxes> spread{};  ///< by which each axis widens the bound, to choose a cut
};

/// The cost of an adapter with the best Ma2: |Fc / Xs|^2, in (N/m)^2; the less, the more the skin
/// moves. Of the skin that moves least, where skins vary. Divided by w Bs where `per_resistance`,
/// so that the least cost is the most power.
class AdapterCost {
 public:
  AdapterCost(const TuningProblem& problem, const MotorSource& source, bool per_resistance);

  /// A lower bound over the box, by the mean value form (sim/tuning/adapter_optimum.h).
  [[nodiscard]] BoxCost Over(const AdapterBox& box) const;

 private:
  using Number = Slope<Interval, kBoxAxes>;
  [[nodiscard]] Number At(const AdapterBox& box) const;

  Interval omega_, case_stiffness_, passive_;  // w; Re kc - Mc w^2 and Im kc
  Range motor_side_mass_kg_, stiffness_n_per_m_, damping_n_s_per_m_;
  Interval least_inertia_, most_inertia_;  // of Ma2 w^2
  Skin first_, last_;                      // at the ends of the area
  Interval variation_;                     // of the skin
  bool per_resistance_;
};

}  // namespace haptometer::sim
