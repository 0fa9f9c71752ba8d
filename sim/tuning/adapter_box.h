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

}  // namespace haptometer::sim
