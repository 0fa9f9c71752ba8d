#pragma once

#include <optional>
#include <string>

#include "sim/skin/skin_rise.h"
#include "sim/waveforms.h"
#include "tools/simulate/scene_answer.h"

namespace haptometer::tools {

/// What an answer tells of its motion beyond RMS and peaks.
struct MotionNumbers {
  /// Least force between contactor and skin, a stated preload and weight in it; without either,
  /// what preload keeps contact, with a minus.
  std::optional<double> contact_force_least_n;
  std::optional<double> efficiency;  ///< power into the skin's damper over electrical power in
  std::optional<sim::SkinRise> rise;
  std::string no_rise;  ///< why not; empty where nothing was asked
};

/// The answer's scene as it was solved: under the effects that were kept.
[[nodiscard]] sim::EffectiveScene EffectiveOf(const SceneAnswer& answer);

/// Where the answer's motion begins.
[[nodiscard]] sim::Beginning StartOf(const SceneAnswer& answer,
                                     const sim::EffectiveScene& effective);

/// The numbers; `played`: the motion from its beginning over the scene's duration, or over some
/// periods of what it settles to; null where it was too long to play. The least force is that of
/// its rows and of its events.
[[nodiscard]] MotionNumbers NumbersOf(const SceneAnswer& answer, const sim::Waveforms* played);

}  // namespace haptometer::tools
