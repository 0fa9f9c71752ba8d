#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>

#include "sim/findings.h"
#include "sim/periodic_motion.h"
#include "sim/scene/effects.h"
#include "sim/scene/scene.h"
#include "sim/scene_run.h"

namespace haptometer::sim {

/// Why an effect is on or off.
enum class Ground : std::uint8_t {
  kNotNamed,      ///< off: the scene does not call for it
  kNamed,         ///< on: the scene calls for it
  kNeverReached,  ///< off: no guard fell, proved between samples too: the same motion, bit for bit
  kSuperposed,    ///< off: gravity in a motion that nothing limits and no spring bends
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

/// How the end of a run under a sine looks, in which stops, contact or smooth effects took part.
struct RunEnd {
  /// After how many periods of the drive it repeats itself; the run's window then holds whole ones
  /// of these: ten periods where that divides ten, else the least multiple above ten that fits.
  std::optional<int> drive_periods;
  /// Where it does not: by what the window's RMS of the skin varies from window to window
  /// (steady_run.h); absent: the run is too short to tell.
  std::optional<double> window_uncertainty;
  double ten_periods_rms_m = 0;  ///< RMS of the skin over the last ten periods
};

/// A scene's effects decided, with the run that decided it.
struct EffectChoice {
  EffectSet on;
  std::array<EffectVerdict, kEffectNames.size()> verdicts{};
  SceneRun run;  ///< of the choice
  /// Of a scene without a duration, how the run repeats itself; absent: it is linear, or
  std::optional<PeriodicMotion> periodic;
  std::optional<ChaoticMotion> chaotic;  ///< it never does, and the run's numbers are averages
  std::optional<RunEnd> end;             ///< of a scene with a duration that something limits
  double change = 0;     ///< of the asked quantity, by all that was left out together, measured
  std::size_t runs = 1;  ///< that the decision took
};

/// A scene played with a set of effects.
struct PlayedScene {
  bool answered = false;
  SceneRun run;
  std::optional<PeriodicMotion> periodic;
  std::optional<ChaoticMotion> chaotic;
  std::optional<RunEnd> end;
  std::optional<Finding> refusal;  ///< why there is no answer
};

/// The scene's run, or without a duration the motion that it settles to (steady_run.h).
[[nodiscard]] PlayedScene PlayWith(const Scene& scene, EffectSet on);

/// Plays the scene with the effects that it calls for, and decides those that are "auto": over its
/// run, or over the motion that it settles to where it has no duration.
///
/// Everything asked about is first played together. Stops and contact whose guards never fell are
/// left out: the motion is the same. Gravity is left out where then nothing limits the motion and
/// no stiffening spring feels where it rests. The others are left out one by one, least change
/// first, as long as the run without them all stays within scene.tolerance of the run with
/// everything, what both may be wrong by included: what is answered never deviates by more. In a
/// motion that stays linear the run without tremor costs microseconds, and without a duration its
/// share is superposed phasors (steady_run.h).
///
/// Cost: one run where nothing is "auto" or all is proved; else up to two more for each effect.
/// Refusals, with every effect on: a run that stalls, no steady motion found, an exact motion
/// beyond prediction, smooth effects that cannot be played as exactly as scene.tolerance asks.
[[nodiscard]] std::expected<EffectChoice, Finding> ChooseEffects(const Scene& scene);

}  // namespace haptometer::sim
