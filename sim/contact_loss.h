#pragma once

#include <Eigen/Core>

#include "sim/piecewise_linear.h"
#include "sim/scene.h"

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

/// The two modes that contact may be in, with what leads from one to the other.
struct ContactModes {
  Mode contact;                  ///< states of the linear scene (n) and a last one that is 1
  Mode flight;                   ///< states of the linear scene, xp where the skin has damping, 1
  Eigen::RowVectorXd force_row;  ///< (n + 1) of the contact's states: F = row x
  Eigen::RowVectorXd gap_row;    ///< of the flight's states: xp - xs
  Eigen::MatrixXd take_off;      ///< (flight's states, n + 1)
  Eigen::MatrixXd landing;       ///< (n + 1, flight's states)
  std::size_t gap_order = 2;     ///< derivatives of the gap that vanish at take-off, with itself
  bool force_at_landing = true;  ///< false: the force begins at zero
};

/// Assembles both. The skin must have stiffness or damping.
[[nodiscard]] ContactModes AssembleContact(const Scene& scene, const ContactLoss& loss);

}  // namespace haptometer::sim
