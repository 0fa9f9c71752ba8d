#pragma once

#include <cstddef>
#include <vector>

#include "sim/tuning/tuning_problem.h"

namespace haptometer::sim {

/// The best point of a grid.
struct GridBest {
  AdapterPoint point;
  double skin_rms_m = 0;
  double score = 0;        ///< the area's weight times skin_rms_m
  std::size_t points = 0;  ///< that the grid has: values_per_axis^5 (^4 with a fixed skin)
};

/// `values` numbers in equal steps, the ends of `range` exactly; one: its lower end.
[[nodiscard]] std::vector<double> EqualSteps(const Range& range, std::size_t values);

/// The largest weight times skin RMS over all points of a linear grid, `values_per_axis` >= 1 on
/// each of the bounds' five ranges; of equals the first in the order Ma1, Ka, Ba, A, Ma2.
///
/// `area_weights`: one a value of the area (Nr for the stimulus); empty: all 1. The problem must
/// have no Fault().
///
/// Every point is accounted for, not every point is visited. With Z = 1/(1/D1 + 1/ka), D1 = kc -
/// (Mc + Ma1) w^2 (sim/linear/motor_source.h),
///
///   |Xs|^2 = |Fc|^2 |ka|^2 / (|D1 + ka|^2 ((Ks + Re Z - Ma2 w^2)^2 + (w Bs + Im Z)^2)),
///
/// and only the square with Ma2 depends on Ma2: on a grid of Ma2 the best one is a neighbour of
/// (Ks + Re Z) / w^2. Z and the factor before it do not depend on the area. So 20^5 points are 20^3
/// values of Z and two candidates for each of 20 areas: 320 000 evaluations of five operations,
/// exact but for rounding. Lindsay 2013, Table 2.2 prints the ranges and "20 values within"; that
/// the steps are equal is our reading.
///
/// With a skin_variation v the first square's root grows by v Ks and Bs by 1 + v: the least RMS
/// over those skins, and still the nearest Ma2 is the best.
///
/// Cost: below 2 ms for 20^5 on one core (bench/adapter_tuning_bench.cc).
[[nodiscard]] GridBest BestOnGrid(const TuningProblem& problem, std::size_t values_per_axis,
                                  const std::vector<double>& area_weights = {});

}  // namespace haptometer::sim
