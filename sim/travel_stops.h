#pragma once

#include <limits>

namespace haptometer::sim {

/// What ends the mover's travel in its case, on two sides. Gaps count from static equilibrium.
///
/// **Rigid** (stiffness infinite): where xv - xa reaches a gap the two exchange momentum and part
/// with e times their speed; bounces that die out leave them at rest against each other until the
/// force between them would pull (piecewise_linear.h).
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

}  // namespace haptometer::sim
