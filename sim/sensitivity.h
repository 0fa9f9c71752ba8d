#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "sim/scene.h"

namespace haptometer::sim {

/// One of the six numbers of adapter and skin.
enum class SceneNumber : std::uint8_t { kMa1, kMa2, kKa, kBa, kKs, kBs };
inline constexpr std::array kSceneNumbers{SceneNumber::kMa1, SceneNumber::kMa2, SceneNumber::kKa,
                                          SceneNumber::kBa,  SceneNumber::kKs,  SceneNumber::kBs};

/// "Ma1", "Ma2", "Ka", "Ba", "Ks", "Bs".
[[nodiscard]] std::string_view Symbol(SceneNumber number);

/// The scene with one of its numbers `factor` times as large. It must have an adapter.
[[nodiscard]] Scene Scaled(Scene scene, SceneNumber number, double factor);

/// RMS of the skin in the steady state of Scaled() over that of `scene` (Lindsay 2013, Figure 2.5).
/// Cost: two steady states.
[[nodiscard]] double RelativeSkinRms(const Scene& scene, SceneNumber number, double factor);

}  // namespace haptometer::sim
