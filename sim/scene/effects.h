#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

namespace haptometer::sim {

/// What ends the mover's travel in its case, on two sides. Gaps count from static equilibrium.
///
/// **Rigid** (stiffness infinite): where xv - xa reaches a gap the two exchange momentum and part
/// with e times their speed; bounces that die out leave them at rest against each other until the
/// force between them would pull (sim/linear/mode.h).
///
/// **Compliant**: penetrating by d > 0 the mover is pushed by F = k d + c d', never pulled. With
/// damping F falls to zero before d does; the mover then runs free while the pad recovers its form
/// with it, F = max(0, k d + c d'), and the pad's energy is dissipated.
struct TravelStops {
  static constexpr double kNone = std::numeric_limits<double>::infinity();

  /// Largest xv - xa, and largest xa - xv; infinite: no stop on this side. Their sum is positive;
  /// one of them is negative where weight or a preload hold the mover at that stop.
  double gap_up_m = kNone;
  double gap_down_m = kNone;
  double stiffness_n_per_m = kNone;  ///< k > 0; infinite: rigid
  double damping_n_s_per_m = 0;      ///< c >= 0, of compliant stops
  double restitution = 0;            ///< e in [0, 1], of rigid stops

  [[nodiscard]] bool rigid() const { return stiffness_n_per_m == kNone; }
};

/// Contact with the skin that can be lost: the skin pushes, it never pulls.
///
/// At rest the skin carries the preload F0 > 0 (the weight on it, or a finger's press). In contact
/// it pushes with F = F0 + Ks xs + Bs vs, positions counted from that equilibrium, towards the skin
/// positive. The motion in contact is that of the linear scene; it holds while F >= 0. Then follows
/// the flight:
///
///   body   M vs' = (what else acts) + F0        the preload is no longer balanced
///   skin   Bs xp' = -(F0 + Ks xp), xp = xs at take-off: free of force, it follows by itself
///
/// and the landing where xs = xp again, with the force Bs (vs - xp') >= 0 at once. (A law without
/// the skin's own motion, F = max(0, F0 + Ks x + Bs v), would push before they touch.) Without
/// damping the skin springs back at once, xp = -F0/Ks.
///
/// Ledger: the preload's work is in the stored energy, which in flight is Ks xp^2/2 + F0 (xp - xs)
/// for the skin; in contact Ks xs^2/2 as in the linear scene.
///
/// Thesis's scenes lift off under their own weight alone: 0.345 N of force against 0.07 N.
struct ContactLoss {
  double preload_n = 0;  ///< F0 > 0
};

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

/// What a scene may call for beyond rigid bodies on linear springs under a steady voltage.
enum class Effect : std::uint8_t {
  kInductance,   ///< the coil's; without it the current follows the voltage at once
  kGravity,      ///< along the axis; moves the mover towards a stop, adds weight to the preload
  kTravelStops,  ///< the mover's travel in its case ends
  kStiffening,   ///< the mover's spring hardens with travel
  kContactLoss,  ///< the skin pushes, it never pulls
  kTremor,       ///< the finger moves by itself
  kCoilHeating,  ///< the coil's resistance rises with the power in it
};

/// As the keys of [effects] are called, in the order of Effect.
inline constexpr std::array<std::string_view, 7> kEffectNames{
    "inductance",   "gravity", "travel_stops", "stiffening",
    "contact_loss", "tremor",  "coil_heating"};

/// A choice of effects; bit by Effect.
using EffectSet = std::bitset<kEffectNames.size()>;

/// The effect's place in an EffectSet and in kEffectNames.
[[nodiscard]] constexpr std::size_t PlaceOf(Effect effect) {
  return static_cast<std::size_t>(effect);
}

/// What a scene says about an effect.
enum class Wish : std::uint8_t {
  kOff,
  kOn,
  kAuto,  ///< off where that is shown to change no number by more than the tolerance
};

/// The scene's effects and their constants, which may be stated for effects that are off.
struct Effects {
  std::array<Wish, kEffectNames.size()> wishes{Wish::kOn};
  double gravity_m_per_s2 = 9.80665;  ///< along the axis, towards the skin positive
  /// Gaps count from where the mover rests without gravity.
  std::optional<TravelStops> travel_stops{};
  /// The preload without the bodies' weight, which gravity adds.
  std::optional<ContactLoss> contact_loss{};
  std::optional<StiffeningSpring> stiffening{};  ///< without sag, which gravity adds
  std::optional<CoilHeating> coil_heating{};
  EffectSet stated{};  ///< whose constants the scene states

  [[nodiscard]] Wish& operator[](Effect effect) { return wishes[PlaceOf(effect)]; }
  [[nodiscard]] Wish operator[](Effect effect) const { return wishes[PlaceOf(effect)]; }
  /// Whether the scene says anything but "the coil has its inductance, nothing else".
  [[nodiscard]] bool Asked() const { return wishes != Effects{}.wishes; }
};

}  // namespace haptometer::sim
