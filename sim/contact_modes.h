#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "sim/contact_loss.h"
#include "sim/piecewise_linear.h"
#include "sim/scene.h"

namespace haptometer::sim {

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
