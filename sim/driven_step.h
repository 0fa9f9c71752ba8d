#pragma once

#include <Eigen/Core>

#include "sim/linear_model.h"
#include "sim/scene.h"

namespace haptometer::sim {

/// G of z = [x, sin w t, cos w t], z' = G z: (n + 2, n + 2).
[[nodiscard]] Eigen::MatrixXd DrivenGenerator(const LinearModel& model, const SineDrive& drive);

/// [sin w t, cos w t], the phase from the whole number of cycles on: exact to rounding at any time.
[[nodiscard]] Eigen::Vector2d DriveAt(double frequency_hz, long double t_s);

/// (n, n + 2): the states after h_s from the states before and the drive *after* the step.
///
/// exp(G h) = [[E, V], [0, R]], R the drive's turn over h; the step is [E, V R^-1]. What the bodies
/// still feel of the drive lies near the end of a long step, so its phase is not carried across
/// thousands of cycles. Cost: one exponential.
[[nodiscard]] Eigen::MatrixXd DrivenStep(const Eigen::MatrixXd& generator, double h_s);

}  // namespace haptometer::sim
