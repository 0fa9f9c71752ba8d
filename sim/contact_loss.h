#pragma once

namespace haptometer::sim {

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

}  // namespace haptometer::sim
