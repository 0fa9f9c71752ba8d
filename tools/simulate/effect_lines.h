#pragma once

#include <string>
#include <vector>

#include "sim/effect_choice.h"
#include "sim/scene/scene.h"

namespace haptometer::tools {

/// What leaving an effect out, or forcing it on, does to the scene's answer.
struct EffectTrial {
  sim::Effect effect;
  /// Of the asked quantity, relative, between with and without it; infinite where one of them has
  /// no answer.
  double change = 0;
  double with_s = 0;  ///< best time of three runs
  double without_s = 0;
};

/// Plays the scene with and without each effect whose constants are stated, around its choice.
/// Cost: six runs for each of them.
[[nodiscard]] std::vector<EffectTrial> TryEffects(const sim::Scene& scene,
                                                  const sim::EffectChoice& choice);

/// "off: never reached, proved between samples too".
[[nodiscard]] std::string VerdictText(const sim::EffectVerdict& verdict);

/// A line for each effect that the scene names.
[[nodiscard]] std::vector<std::string> EffectLines(const sim::Scene& scene,
                                                   const sim::EffectChoice& choice);

/// The table of `simulate --explain`.
[[nodiscard]] std::string ExplainText(const sim::Scene& scene, const sim::EffectChoice& choice,
                                      const std::vector<EffectTrial>& trials);

}  // namespace haptometer::tools
