#pragma once

#include <cstddef>

namespace haptometer::sim {

/// Prints rows of docs/sim_cost.csv: the adapter scene, pressed on with 0.05 N, as its effects are
/// added one by one ("with effects"), and with all of them but one ("without"). Errors are against
/// all of them.
void MeasureEffects(std::size_t outputs, int runs);

}  // namespace haptometer::sim
