#pragma once

// The methods of sim/, and what sim/ does not do to its inputs, put to the questions of
// sim_cost.cc.

#include <cstddef>

#include "bench/sim_cost_bodies.h"
#include "bench/sim_cost_peers.h"
#include "sim/piecewise/piecewise_scene.h"
#include "sim/scene/scene.h"
#include "sim/smooth/smooth_system.h"

namespace haptometer::sim {

/// The question as sim/ asks it.
[[nodiscard]] Scene SceneOf(const Question& question);
[[nodiscard]] PiecewiseEffects PiecewiseOf(const Question& question);
[[nodiscard]] SmoothEffects SmoothOf(const Question& question);

/// Linear questions: one exponential with the drive's generator, then a product for each output.
[[nodiscard]] Answer ByExactSteps(const Question& question, std::size_t outputs);

/// The same, every output asked for by itself.
[[nodiscard]] Answer ByQuestions(const Question& question, std::size_t outputs);

/// What tools for linear systems do (lsim, c2d): the exact step of an input that is held, or joined
/// by straight lines, between its samples, `inner` of them for each output.
enum class Hold : std::uint8_t { kZeroOrder, kFirstOrder };
[[nodiscard]] Answer ByHolding(const Question& question, std::size_t outputs, Hold hold, int inner);

/// Stops and breaking contact, exact.
[[nodiscard]] Answer ByPieces(const Question& question, std::size_t outputs);

/// Anything, to a tolerance.
[[nodiscard]] Answer BySmoothMotion(const Question& question, std::size_t outputs,
                                    double tolerance);

}  // namespace haptometer::sim
