#pragma once

namespace haptometer::sim {

/// The coil warms up, and its resistance with it: one state more, the rise theta in K above the
/// temperature at which the actuator's resistance R0 holds.
///
///   R(theta) = R0 (1 + alpha theta)
///   C theta' = R(theta) i^2 - theta / Rth
///
/// One body of heat and one way out: the slow rise of the case is not modelled.
struct CoilHeating {
  /// alpha, of copper at 20 degrees (IEC 60028: 1/254.45 per K, rounded)
  static constexpr double kCopperPerK = 3.93e-3;

  double heat_capacity_j_per_k = 0;       ///< C > 0
  double thermal_resistance_k_per_w = 0;  ///< Rth > 0; infinite: no heat leaves
  double resistance_per_k = kCopperPerK;  ///< alpha >= 0
};

}  // namespace haptometer::sim
