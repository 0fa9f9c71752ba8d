#pragma once

#include <optional>

#include "sim/linear/mode.h"
#include "sim/piecewise/piecewise_motion.h"
#include "sim/scene/effects.h"
#include "sim/scene/scene.h"

namespace haptometer::sim {

/// The piecewise-linear effects that a scene calls for; absent is off.
struct PiecewiseEffects {
  std::optional<TravelStops> stops{};
  std::optional<ContactLoss> contact_loss{};
};

/// The scene with its effects. Mode 0 is the linear scene, free of stops and in contact, with the
/// very matrices that it has without effects: as long as no guard is reached the samples have the
/// same bits. `positions` are LinearModel's states throughout, the ledger's elements
/// kSceneElements.
///
/// Modes: (contact, flight) x (free, and each stop's states). With both effects there are up to 10;
/// those that are never entered cost their assembly alone. Cost: some 10 to 50 us.
[[nodiscard]] PiecewiseLinearSystem AssemblePiecewise(const Scene& scene,
                                                      const PiecewiseEffects& effects);

/// What WatchTravelAndForce() adds to each mode, by place.
inline constexpr std::size_t kWatchedTravel = 0;
inline constexpr std::size_t kWatchedForce = 1;

/// Has a motion of the system watch xv - xa, and what presses on the skin beyond what does at rest:
/// Ks (xs - xg) + Bs (vs - vg), in flight less the preload.
void WatchTravelAndForce(const Scene& scene, const PiecewiseEffects& effects,
                         PiecewiseLinearSystem& system);

/// Where the scene begins: at rest, in its stated initial state or in the steady motion of its
/// linear part under a sine or tones, mode 0.
[[nodiscard]] PiecewiseStart PiecewiseStartOf(const Scene& scene);

}  // namespace haptometer::sim
