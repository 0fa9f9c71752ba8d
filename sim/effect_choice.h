#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sim/effects.h"
#include "sim/scene.h"
#include "sim/scene_run.h"

namespace haptometer::sim {

/// Why an effect is on or off.
enum class Ground : std::uint8_t {
  kNotNamed,      ///< off: the scene does not call for it
  kNamed,         ///< on: the scene calls for it
  kNeverReached,  ///< off: no guard fell, proved between samples too: the same motion, bit for bit
  kSuperposed,    ///< off: gravity in a motion that no stop or lost contact limits
  kCompared,      ///< on or off: the runs with and without it were compared
};

/// What was decided about one effect.
struct EffectVerdict {
  bool on = false;
  Ground ground = Ground::kNotNamed;
  /// Relative change of the asked quantity by leaving this effect alone out; 0 where that is proved
  /// or nothing was asked.
  double change = 0;
};

/// A scene's effects decided, with the run that decided it.
struct EffectChoice {
  EffectSet on;
  std::array<EffectVerdict, kEffectNames.size()> verdicts{};
  SceneRun run;          ///< of the choice
  double change = 0;     ///< of the asked quantity, by all that was left out together, measured
  std::size_t runs = 1;  ///< that the decision took
};

/// The relative deviation of the scene's asked quantity between two runs of the same length.
[[nodiscard]] double Deviation(AskedQuantity quantity, const SceneRun& run,
                               const SceneRun& reference);

/// Plays the scene with the effects that it calls for, and decides those that are "auto".
///
/// Everything asked about is first played together. Stops and contact whose guards never fell are
/// left out: the motion is the same. Gravity is left out where then nothing limits the motion. The
/// others are left out one by one, least change first, as long as the run without them all stays
/// within scene.tolerance of the run with everything: what is answered never deviates by more.
///
/// Cost: one run where nothing is "auto" or all is proved; else up to two more for each effect.
[[nodiscard]] EffectChoice ChooseEffects(const Scene& scene, double duration_s);

}  // namespace haptometer::sim
