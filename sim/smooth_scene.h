#pragma once

#include <optional>

#include "sim/coil_heating.h"
#include "sim/piecewise_scene.h"
#include "sim/scene.h"
#include "sim/smooth_system.h"
#include "sim/stiffening_spring.h"

namespace haptometer::sim {

/// The smooth nonlinear effects that a scene calls for; absent is off.
struct SmoothEffects {
  std::optional<StiffeningSpring> spring{};
  std::optional<CoilHeating> heating{};

  [[nodiscard]] bool Any() const { return spring.has_value() || heating.has_value(); }
};

/// The scene with all its effects, for SmoothMotion; modes and transitions are those of
/// AssemblePiecewise.
///
/// The spring's place in each mode, whatever its coordinates, is read off the assembly itself: all
/// matrices are affine in Kv, so those for a Kv larger by 2^40 N/m differ by 2^40 times what a
/// newton does, exact to rounding. Cost: two assemblies.
[[nodiscard]] SmoothSystem AssembleSmooth(const Scene& scene, const PiecewiseEffects& piecewise,
                                          const SmoothEffects& smooth);

}  // namespace haptometer::sim
