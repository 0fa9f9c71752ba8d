#include "sim/stiffening_spring.h"

#include <cmath>

#include "base/error.h"

namespace haptometer::sim {

double SagUnder(double force_n, double stiffness_n_per_m, double cubic_n_per_m3) {
  const double Kv = stiffness_n_per_m, K3 = cubic_n_per_m3;
  HAPTOMETER_CHECK(Kv >= 0 && K3 >= 0 && Kv + K3 > 0, "Kv {} N/m, K3 {} N/m^3", Kv, K3);
  if (!(K3 > 0)) return force_n / Kv;
  if (!(Kv > 0)) return std::cbrt(force_n / K3);
  const double p_m = std::sqrt(Kv / (3 * K3));
  return 2 * p_m * std::sinh(std::asinh(3 * force_n / (2 * p_m * Kv)) / 3);
}

}  // namespace haptometer::sim
