#pragma once

#include <cmath>

namespace haptometer::sim {

/// What an actuator's ring-down after a blow depends on; T is double or an
/// automatic-differentiation number.
template <typename T>
struct RingDownParameters {
  T stiffness_n_per_m;                 ///< Kv > 0
  T damping_n_s_per_m;                 ///< Bv >= 0, mechanical alone
  T force_constant_squared_n2_per_a2;  ///< Km^2; below 0 in a search at most
  T mass_kg;                ///< of the relative motion: Mv (case held) or Mv Mc/(Mv+Mc) (case free)
  T coil_resistance_ohm;    ///< R; not used with an open circuit
  double inductance_h = 0;  ///< L >= 0; not used with an open circuit
  double load_ohm = 0;      ///< across the terminals, 0 (shorted) to infinity (open)
};

/// The pair e^(-s t) cosh(r t) and e^(-s t) sinh(r t) / r with r^2 = s^2 - q.
template <typename T>
struct DampedPair {
  T even;  ///< e^(-s t) cosh(r t)
  T odd;   ///< e^(-s t) sinh(r t) / r, in seconds
};

/// The fundamental solutions of x'' + 2 s x' + q x = 0 for t >= 0.
///
/// Both are entire functions of r^2 = s^2 - q, so critical damping is not a special case: a power
/// series serves |r t|^2 < 1/4, cosine and sine below, decaying exponentials above (no overflow,
/// however large the damping).
///
/// @param decay_per_s   s, in 1/s
/// @param stiffness_per_s2  q, in 1/s^2
/// @param time_s        t in seconds
/// Relative error: 4e-16 + 2e-16 |r t|, the rounding of the argument. No allocation.
template <typename T>
DampedPair<T> DampedFundamentals(const T& decay_per_s, const T& stiffness_per_s2, const T& time_s) {
  using std::cos;
  using std::exp;
  using std::sin;
  using std::sqrt;
  const T discriminant = decay_per_s * decay_per_s - stiffness_per_s2;
  const T z = discriminant * time_s * time_s;
  if (z < -0.25) {
    const T rate = sqrt(-discriminant);
    const T envelope = exp(-decay_per_s * time_s);
    return {envelope * cos(rate * time_s), envelope * sin(rate * time_s) / rate};
  }
  if (z > 0.25) {
    // the slow root as q / (s + r), free of cancellation
    const T rate = sqrt(discriminant);
    const T slow = exp(-stiffness_per_s2 / (decay_per_s + rate) * time_s);
    const T between = exp(-2.0 * rate * time_s);
    return {0.5 * slow * (1.0 + between), 0.5 * slow * (1.0 - between) / rate};
  }
  // sum of z^k/(2k)! and z^k/(2k+1)!, highest term first; the ninth term is below 1e-20
  T even(1.0);
  T odd(1.0);
  for (int k = 8; k >= 1; --k) {
    const double n = 2.0 * k;
    even = 1.0 + even * z / (n * (n - 1.0));
    odd = 1.0 + odd * z / (n * (n + 1.0));
  }
  const T envelope = exp(-decay_per_s * time_s);
  return {envelope * even, envelope * odd * time_s};
}

/// A signal of a ringing circuit: even E(t) + odd O(t) + electrical e^(-p t), E and O being
/// DampedFundamentals' pair; the last part is 0 before the motion begins.
template <typename T>
struct RingingShape {
  T even;
  T odd;
  T electrical;
};

/// The terminal voltage of an actuator that rings after a blow, in closed form with the coil's
/// inductance exact.
///
/// The motion x = xv - xa of mover against case and the coil's current follow
///
///     M x'' + Bv x' + Kv x = -Km i,    L i' + (R + RL) i = Km x',    i(0) = 0, x(0) = 0, x'(0) =
///     v0
///
/// (J. Lindsay, "A Mechanical Amplifier for Haptic Feedback", University of Washington 2013,
/// equations 2.1-2.3 with the case held or free and the load RL across the terminals). The
/// characteristic polynomial is split as (s + p)(s^2 + 2 d s + q), p the fast electrical root. With
/// G = 1/(R+RL), T = L G, w^2 = Kv/M, b = Bv/2M and y = p T, y is the largest root of
///
///     (1 - y)(y^2 - 2 b T y + (w T)^2) = T G Km^2/M y,    0 < y <= 1,
///
/// found by Newton's iteration from 1, and without cancellation
///
///     2 d = 2 b + (G Km^2/M) y / (y^2 - 2 b T y + (w T)^2),    q = w^2 / y,
///     u(t) / (Km v0) = -RL G (y/n) {e^(-d t) [C + (T q/y - d) S] - e^(-y t/T)},
///     n = y^2 - 2 d T y + T^2 q.
///
/// An open circuit is G = 0 and L = 0 is T = 0: nothing is special there. Holds while the
/// electrical pole is the fastest one (b T < 1); its digits are lost as eps/n, and n > 0.99 for any
/// actuator whose L/R is below 1/200 of its decay time.
template <typename T>
class RingDown {
 public:
  /// Solves for the poles: about 200 ns with doubles. No allocation.
  explicit RingDown(const RingDownParameters<T>& parameters);

  /// d: amplitudes fall as e^(-d t), in 1/s (underdamped).
  const T& decay_per_s() const { return decay_per_s_; }
  /// q of s^2 + 2 d s + q, in 1/s^2; its root is the ringing system's natural angular frequency.
  const T& stiffness_per_s2() const { return stiffness_per_s2_; }
  /// p, the coil's current's own decay; 0 without inductance or load.
  const T& electrical_rate_per_s() const { return electrical_rate_per_s_; }
  /// Terminal voltage per volt of Km v0, the speed voltage of the blow.
  ///
  /// Its sign is that of the thesis (equation 2.1): at first -1 without inductance and load.
  /// Relative to the largest voltage the error is below 1e-13 up to 100 cycles.
  const RingingShape<T>& voltage() const { return voltage_; }
  /// Displacement of mover against case per speed of the blow, x(t)/v0 in seconds:
  ///
  ///     {e^(-d t) [((1 - y)(y - d T) + n) S - T (1 - y) C] + T (1 - y) e^(-y t/T)} / n,
  ///
  /// C and S being DampedFundamentals' pair; error below 1e-13 of the largest displacement up to
  /// 100 cycles.
  const RingingShape<T>& displacement() const { return displacement_; }
  /// Terminal voltage after a current I0 that held the mover out of its place is interrupted, per
  /// Km^2 I0/M, in seconds: x(0) = Km I0/Kv, x'(0) = 0, i(0) = 0, and
  ///
  ///     -RL G {e^(-d t) [(y - d T) S - T C] + T e^(-y t/T)} / n.
  ///
  /// Without inductance and load it is the blow's displacement, turned. What the current's own
  /// decay through a load would add is a blow of T w of the motion, 1e-3 for an LRA's coil: a shift
  /// in time, and (T w)^2 of the amplitude.
  const RingingShape<T>& release() const { return release_; }

 private:
  T decay_per_s_;
  T stiffness_per_s2_;
  T electrical_rate_per_s_;  // y / T; 0 where T is 0
  RingingShape<T> voltage_;
  RingingShape<T> displacement_;
  RingingShape<T> release_;
};

template <typename T>
RingDown<T>::RingDown(const RingDownParameters<T>& parameters) {
  const bool open = std::isinf(parameters.load_ohm);
  const T total_ohm = open ? T(1.0) : T(parameters.coil_resistance_ohm + parameters.load_ohm);
  const T conductance = open ? T(0.0) : T(1.0 / total_ohm);
  const T divider = open ? T(1.0) : T(parameters.load_ohm / total_ohm);
  const T tau = parameters.inductance_h * conductance;
  const T twice_b = parameters.damping_n_s_per_m / parameters.mass_kg;
  const T w2 = parameters.stiffness_n_per_m / parameters.mass_kg;
  const T g = parameters.force_constant_squared_n2_per_a2 * conductance / parameters.mass_kg;

  // Newton from y = 1 falls monotonically on the largest root; the step after convergence also
  // carries the derivatives of an automatic-differentiation number
  constexpr int kMostSteps = 50;
  T y(1.0);
  for (int step = 0; step < kMostSteps; ++step) {
    const T square = y * y - twice_b * tau * y + tau * tau * w2;
    const T value = (1.0 - y) * square - tau * g * y;
    const T slope = (1.0 - y) * (2.0 * y - twice_b * tau) - square - tau * g;
    const T next = y - value / slope;
    const bool settled = !(next < y);
    y = next;
    if (settled) break;
  }

  const T square = y * y - twice_b * tau * y + tau * tau * w2;
  decay_per_s_ = 0.5 * (twice_b + g * y / square);
  stiffness_per_s2_ = w2 / y;
  const T n = y * y - 2.0 * decay_per_s_ * tau * y + tau * tau * stiffness_per_s2_;
  const T lag_s = tau / n;
  const T swing = (y - decay_per_s_ * tau) / n;
  const T loss = 1.0 - y;  // by this the current lags behind the motion
  const T gain = -divider * y / n;
  voltage_ = {gain, gain * (tau * stiffness_per_s2_ / y - decay_per_s_), -gain};
  displacement_ = {-lag_s * loss, 1.0 + loss * swing, lag_s * loss};
  release_ = {divider * lag_s, -divider * swing, -divider * lag_s};
  electrical_rate_per_s_ = tau > 0.0 ? T(y / tau) : T(0.0);
}

}  // namespace haptometer::sim
