#pragma once

#include <vector>

#include "sim/tuning/adapter_objective.h"
#include "sim/tuning/cube_place.h"

namespace haptometer::sim {

/// Places to begin a climb at, all but Ma2, which is 0: a lattice, and the ridge.
///
/// The lattice has 9 places an axis, evenly over the cube; evenly over the logarithm of what moves
/// with the case, Mc + Ma1, where that spans more than a factor of 20, and in steps of 8 down from
/// the upper end where Ba may be 0.
///
/// The ridge, whatever the bounds' width: with sim/tuning/adapter_cost.h's letters (no price) and
/// g = 0 the cost is least over S where S = h / b, which is
///
///   b ((Ka + p)^2 + (e + q)^2) = q (Ka^2 + e^2) + e (p^2 + q^2),
///
/// a square in Ka and one in p, so in Ma1. Each is solved with the others on the lattice; without a
/// root within the bounds its end stands for it.
[[nodiscard]] std::vector<CubePlace> StartPlaces(const TuningProblem& problem,
                                                 const MotorSource& source);

}  // namespace haptometer::sim
