#pragma once

#include "sim/effective_scene.h"
#include "sim/scene.h"
#include "trial/sensor_head.h"

namespace haptometer::sim {

/// The displacement of `target` under a scene's effects, at any time, as it is asked for: exact, or
/// by SmoothMotion with the first tolerance of solver_ladder.h where smooth effects are on.
///
/// The motion is played in the outputs of output_rate.h and interpolated by quintics: 2e-11 of its
/// amplitude where it is smooth, h^2/8 times the jump of acceleration within an output step
/// that holds an event. Before t = 0 it stands at its first value. Questions should come in
/// ascending order, give or take 4096 outputs; an earlier one plays the motion anew. NaN after a
/// stall. Threads may share it: they wait for each other.
///
/// `start` is the state at t = 0, `temperature_rise_k` the coil's.
[[nodiscard]] trial::Displacement PlayedMotion(const EffectiveScene& scene, PiecewiseStart start,
                                               SensorTarget target, double temperature_rise_k = 0);

}  // namespace haptometer::sim
