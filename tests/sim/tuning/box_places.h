#pragma once

#include <array>
#include <cmath>
#include <random>

#include "sim/tuning/adapter_cost.h"

namespace haptometer::tests {

/// Of the unit cube: Ma1, Ka, Ba and the area's part.
using Place = std::array<double, sim::kBoxAxes>;

/// The adapter at a place of the problem's bounds, with that Ma2.
inline sim::Adapter AdapterAt(const sim::TuningProblem& problem, const Place& place,
                              double skin_side_mass_kg) {
  const sim::AdapterBounds& bounds = problem.bounds;
  return {.motor_side_mass_kg = bounds.motor_side_mass_kg.At(place[0]),
          .skin_side_mass_kg = skin_side_mass_kg,
          .stiffness_n_per_m = bounds.stiffness_n_per_m.At(place[1]),
          .damping_n_s_per_m = bounds.damping_n_s_per_m.At(place[2])};
}

/// A box of the unit cube, and a place in it.
struct BoxWithPlace {
  sim::AdapterBox box;
  Place place{};
};

/// As wide along every axis as 10^-4 to 1, evenly over its logarithm.
inline BoxWithPlace RandomBox(std::mt19937& random) {
  std::uniform_real_distribution<double> part(0, 1);
  BoxWithPlace drawn;
  const double size = std::pow(10, -4 * part(random));
  for (std::size_t axis = 0; axis < sim::kBoxAxes; ++axis) {
    drawn.box[axis].lower = (1 - size) * part(random);
    drawn.box[axis].upper = drawn.box[axis].lower + size;
    drawn.place[axis] = drawn.box[axis].lower + size * part(random);
  }
  return drawn;
}

}  // namespace haptometer::tests
