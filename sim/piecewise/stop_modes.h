#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/linear/mode.h"
#include "sim/scene/effects.h"
#include "sim/scene/scene.h"

namespace haptometer::sim {

/// How mover and case stand to each other.
enum class StopState : std::uint8_t {
  kFree,
  kResting,  ///< rigid: together
  kPressed,  ///< compliant: F = k d + c d' > 0
  kLeaving,  ///< compliant: d > 0, F = 0
};

/// A mode under a stop's state, in coordinates that suit it: y = to z, z = from y + shift, z the
/// states of the mode it was made of, with their last state 1.
struct StopMode {
  Mode mode;
  StopState state = StopState::kFree;
  int side = 0;  ///< +1 up, -1 down, 0 free
  Eigen::MatrixXd to;
  Eigen::MatrixXd from;
  Eigen::VectorXd shift;
  std::vector<Eigen::RowVectorXd> guards{};  ///< of y with its last state 1; none when free
  Eigen::RowVectorXd feed{};                 ///< of u, to the first of them; empty: none
};

/// The states that the stops need, free first, on top of `base`, whose last state is 1 and whose
/// first are LinearModel's.
///
/// Pressed and leaving have d and d' in place of xv and vv, so that neither the stiffest stop nor
/// the smallest penetration is a difference of large numbers; resting does without both, and its
/// force F = m (acceleration that the free bodies would have towards each other), 1/m = 1/Mv +
/// 1/Mc1, is what holds it. Guards: resting {F}, pressed {F}, leaving {d, -F}. The free state keeps
/// `base`'s matrices as they are.
[[nodiscard]] std::vector<StopMode> AssembleStopModes(const Scene& scene, const TravelStops& stops,
                                                      const Mode& base);

/// The gap on a side in `states` states whose last is 1, as a row: >= 0 where there is room.
[[nodiscard]] Eigen::RowVectorXd StopGapRow(const TravelStops& stops, int side,
                                            Eigen::Index states);

/// z after an impact on a side, from z before: (states, states).
[[nodiscard]] Eigen::MatrixXd ImpactMap(const Scene& scene, const TravelStops& stops, int side,
                                        Eigen::Index states);

/// The gap on a side; infinite where there is none.
[[nodiscard]] double GapOn(const TravelStops& stops, int side);

/// The two modes that contact may be in, with what leads from one to the other.
struct ContactModes {
  Mode contact;                  ///< states of the linear scene (n) and a last one that is 1
  Mode flight;                   ///< states of the linear scene, xp where the skin has damping, 1
  Eigen::RowVectorXd force_row;  ///< (n + 1) of the contact's states: F = row x
  Eigen::RowVectorXd gap_row;    ///< of the flight's states: xp - xs
  Eigen::MatrixXd take_off;      ///< (flight's states, n + 1)
  Eigen::MatrixXd landing;       ///< (n + 1, flight's states)
  Eigen::RowVectorXd force_feed{};  ///< (kInputs) of u, to be added to the force; empty: none
  Eigen::RowVectorXd gap_feed{};    ///< the same of the gap
  std::size_t gap_order = 2;        ///< derivatives of the gap that vanish at take-off, with itself
  bool force_at_landing = true;     ///< false: the force begins at zero
};

/// Assembles both. The skin must have stiffness or damping.
[[nodiscard]] ContactModes AssembleContact(const Scene& scene, const ContactLoss& loss);

}  // namespace haptometer::sim
