#pragma once

#include "sim/effective_scene.h"
#include "sim/scene.h"
#include "trial/sensor_head.h"

namespace haptometer::sim {

/// The displacement of `target` under stops and lost contact, at any time, as it is asked for.
///
/// The motion is played in the outputs of output_rate.h and interpolated by quintics: 2e-11 of its
/// amplitude where it is smooth, h^2/8 times the jump of acceleration within an output step
/// that holds an event. Before t = 0 it stands at its first value. Questions should come in
/// ascending order, give or take 4096 outputs; an earlier one plays the motion anew. NaN after a
/// stall. Threads may share it: they wait for each other.
///
/// `start` is the state at t = 0.
[[nodiscard]] trial::Displacement PlayedMotion(const EffectiveScene& scene, PiecewiseStart start,
                                               SensorTarget target);

}  // namespace haptometer::sim
