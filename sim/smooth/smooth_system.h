#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "sim/linear/mode.h"
#include "sim/piecewise/piecewise_scene.h"
#include "sim/scene/effects.h"
#include "sim/scene/scene.h"

namespace haptometer::sim {

/// What the spring does in one mode, in the mode's coordinates: x' = A x + b v - push f(d).
struct SpringTerms {
  Eigen::RowVectorXd deflection;      ///< (n): d = row x, in m
  Eigen::VectorXd push;               ///< (n): x' for a newton that pulls mover and case together
  std::vector<double> guard_pulls{};  ///< of each guard: g = row x + offset - pull f(d); a guard
                                      ///< that feels the spring is one of a mode where d rests
};

/// A piecewise-linear system with smooth nonlinear terms:
///
///   x' = A x + b (v - R0 alpha theta i) + finger [xg, vg] - push f(d)
///   theta' = (R(theta) i^2 - theta / Rth) / C
///
/// with the coil's current i = current_row x, or without inductance what R(theta) makes of it,
/// i = (current_row x + k v) / (1 + k R0 alpha theta), k = 1 / (R0 + source's).
struct SmoothSystem {
  PiecewiseLinearSystem linear;
  std::optional<StiffeningSpring> spring{};
  std::vector<SpringTerms> spring_terms{};  ///< one for each mode; empty without a spring
  std::optional<CoilHeating> heating{};
  double resistance_ohm = 0;       ///< R0
  std::size_t coil_element = 0;    ///< the dissipating element whose form is R0 i^2
  std::size_t source_element = 0;  ///< the one in series with it
};

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
