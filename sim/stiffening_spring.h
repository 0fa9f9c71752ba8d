#pragma once

namespace haptometer::sim {

/// The actuator's spring, stiffer the further it is stretched: Kv d + K3 d^3 from its own length.
///
/// Positions count from static equilibrium, where the spring is already stretched by the sag s
/// under the mover's weight. What is added there to the linear scene's Kv d is
///
///   f(d) = K3 ((d + s)^3 - s^3) = K3 d (d^2 + 3 s d + 3 s^2),    d = xv - xa,
///
/// on mover and case against each other. Its energy from equilibrium is never negative:
///
///   U(d) = K3 d^2 (d^2/4 + s d + 3/2 s^2) = K3 d^2 ((d + 2 s)^2 / 4 + s^2 / 2).
struct StiffeningSpring {
  double cubic_n_per_m3 = 0;  ///< K3 >= 0
  double sag_m = 0;           ///< s, of the sign of d; 0 without gravity

  /// f(d) in N, without Kv d.
  [[nodiscard]] double Force(double d_m) const {
    return cubic_n_per_m3 * d_m * (d_m * d_m + 3 * sag_m * (d_m + sag_m));
  }
  /// f'(d) = 3 K3 (d + s)^2 in N/m.
  [[nodiscard]] double Stiffness(double d_m) const {
    return 3 * cubic_n_per_m3 * (d_m + sag_m) * (d_m + sag_m);
  }
  /// f''(d) = 6 K3 (d + s) in N/m^2.
  [[nodiscard]] double Stiffening(double d_m) const { return 6 * cubic_n_per_m3 * (d_m + sag_m); }
  /// U(d) in J, without Kv d^2/2.
  [[nodiscard]] double Energy(double d_m) const {
    const double far_m = d_m + 2 * sag_m;
    return cubic_n_per_m3 * d_m * d_m * (far_m * far_m / 4 + sag_m * sag_m / 2);
  }
};

/// The sag s of Kv s + K3 s^3 = F under a weight F, of the sign of F. Kv > 0 or K3 > 0.
///
/// The cubic's only real root as a hyperbolic sine, s = 2 p sinh(asinh(3 F / (2 p Kv)) / 3) with
/// p = sqrt(Kv / (3 K3)): no digits cancel, from K3 = 0 (F/Kv) to Kv = 0 ((F/K3)^(1/3)).
[[nodiscard]] double SagUnder(double force_n, double stiffness_n_per_m, double cubic_n_per_m3);

}  // namespace haptometer::sim
