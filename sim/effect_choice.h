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
  kBounded,       ///< off: no number changes by more than a bound that was found before any run
  kKept,          ///< on: neither proof nor bound shows that it may be left out
};

/// What was decided about one effect.
struct EffectVerdict {
  bool on = false;
  Ground ground = Ground::kNotNamed;
  /// Of an effect that was left out, bound of the relative change of any number; 0 where it is
  /// proved that there is none. Absent of the others.
  std::optional<double> change{};
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
  double change = 0;     ///< of any number by all that was left out together, at most; relative
  std::size_t runs = 0;  ///< that the decision took
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

/// Adds a note for what the scene states and its answer does not use: constants of an effect that
/// is off, and a start of a scene without a duration whose steady motion does not depend on it.
void NoteUnused(const Scene& scene, Findings& findings);

/// The scene's run, or without a duration the motion that it settles to (steady_run.h).
[[nodiscard]] PlayedScene PlayWith(const Scene& scene, EffectSet on);

/// Plays the scene with the effects that it calls for: those that are "auto" are left out where a
/// bound or a proof shows that no number changes by more than the tolerance.
///
/// **Before any run of them** stiffening, coil heating and tremor, by effect_bound.h, as long as
/// all that is left out changes no number by more than half of scene.tolerance; what remains is
/// played with the rest of it. That takes the run without them, exact and cheap, which is the
/// answer where all three are left out. **After the run** stops and contact whose guards never
/// fell: the motion is the same; and gravity where then nothing limits the motion and no stiffening
/// spring feels where it rests. All others stay, which costs no more than to find out: whoever
/// wants to know what they change compares PlayWith and without. An inductance costs nothing and
/// stays.
///
/// Cost: one run; with stiffening, heating or tremor that stays, and is "auto", that of the linear
/// scene too.
/// Refusals, with every effect on that stays: a run that stalls, no steady motion found, an exact
/// motion beyond prediction, smooth effects that cannot be played as exactly as scene.tolerance
/// asks.
[[nodiscard]] std::expected<EffectChoice, Finding> ChooseEffects(const Scene& scene);

}  // namespace haptometer::sim
