#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

#include "sim/driven_step.h"
#include "sim/linear_model.h"
#include "sim/scene.h"

namespace haptometer::sim {

/// The states at start_s + i / rate_hz, i = 0 .. count - 1, one column each: (n, count).
///
/// Exact at any rate: the exponential of one step (driven_step.h), then a product a sample; the
/// drive's phase is that of the sample's number, so it does not drift. Of 1000 samples of the
/// thesis's adapter scene every state is within 2e-13 of its peak.
///
/// @param initial (n) the states at start_s
/// Cost: one exponential and some 15 ns a sample of seven states; no allocation but the result's
/// and the exponential's.
[[nodiscard]] Eigen::MatrixXd UniformMotion(const LinearModel& model, const SineDrive& drive,
                                            const Eigen::VectorXd& initial, double start_s,
                                            double rate_hz, std::size_t count);

/// The states that follow sample `first`, whose state is x, one column each: what UniformMotion
/// steps with, for (n, n + 2) `step` of 4 <= n <= 7 states. samples: (n, any number).
void StepUniformly(const Eigen::MatrixXd& step, DriveSequence& drive, std::uint64_t first,
                   const Eigen::VectorXd& x, Eigen::Ref<Eigen::MatrixXd> samples);

}  // namespace haptometer::sim
