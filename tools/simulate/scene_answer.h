#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "sim/effect_choice.h"
#include "sim/findings.h"
#include "sim/linear/steady_state.h"
#include "sim/scene/scene.h"
#include "sim/skin/skin_rise.h"
#include "sim/waveforms.h"
#include "tools/document/document.h"
#include "tools/document/keys.h"

namespace haptometer::tools {

/// Periods of the drive that the window of window_rms_m holds.
inline constexpr double kWindowPeriods = 10;

/// RMS of the skin over the last ten periods of a run.
struct WindowAnswer {
  double begin_s = 0;
  double end_s = 0;
  double skin_rms_m = 0;
  double error_estimate = 0;  ///< bound of its relative error
};

/// What a scene comes to.
struct SceneAnswer {
  sim::Scene scene;
  /// The linear steady motion; absent where stops or lost contact limit it, smooth effects bend it
  /// or tremor adds to it. Without a duration
  /// `effects` then has the motion that the scene settles to.
  std::optional<sim::SteadyState> steady;
  std::optional<sim::SteadyTones> tones;  ///< the same under tones, of a scene without a duration
  std::optional<WindowAnswer> window;     ///< with a duration of at least ten periods
  /// What became of its effects, and the run that they were decided by; absent where the scene
  /// names none.
  std::optional<sim::EffectChoice> effects;
  /// The run of a scene without effects whose drive is no sine.
  std::optional<sim::SceneRun> plain_run;
};

/// The run that was played for the answer, with effects or without; null where none was needed.
[[nodiscard]] const sim::SceneRun* RunOf(const SceneAnswer& answer);

/// The motion that a scene without a duration settles to where it is not `steady`; null for others.
[[nodiscard]] const sim::SceneRun* SettledRun(const SceneAnswer& answer);

/// Whether that is a steady motion of the drive to which the finger's is added.
[[nodiscard]] bool IsSuperposed(const SceneAnswer& answer);

/// Decides the scene's effects; `where` names it in errors.
/// Errors (Cause::kCannotAnswer): ChooseEffects's refusals in words; a run too long to play; a
/// drive other than a sine without a duration or from a steady start.
[[nodiscard]] Result<sim::EffectChoice> DecideEffects(const sim::Scene& scene,
                                                      const std::string& where);

/// Solves the scene; `where` names it in errors.
/// Under a sine: the steady state, with a duration the last ten periods. Under tones without a
/// duration and without effects: their steady state. Under any other drive: the run, which needs a
/// duration.
/// Errors (Cause::kCannotAnswer): as DecideEffects; an undamped resonance, or a frequency at which
/// the skin's motion is lost in rounding; a scene without a duration whose motion settles to
/// nothing that was found.
[[nodiscard]] Result<SceneAnswer> AnswerScene(const sim::Scene& scene, const std::string& where);

/// A number of an answer under its key, as `simulate` and `sweep` have it.
struct AnswerNumber {
  document::Key key;
  std::optional<double> (*of)(const SceneAnswer& answer);  ///< empty: not in this answer
};

/// Of the steady motion, or of what a limited scene settles to: RMS values, peak, power, phase and
/// force.
[[nodiscard]] std::span<const AnswerNumber> SteadyNumbers();

/// Of the run that was played, which `simulate --json` has under `run`.
[[nodiscard]] std::span<const AnswerNumber> RunNumbers();

/// The motion over the scene's duration, or over 8 periods of the one that is reached without one;
/// nothing where neither exists or is too long. Cost: a run.
[[nodiscard]] std::optional<sim::Waveforms> PlayedMotion(const SceneAnswer& answer);

// further keys of simulate, sweep and compare
inline constexpr document::Key kCaseRms{"case_rms_m", "case displacement (RMS)", document::kMetre};
inline constexpr document::Key kWindowRms{"window_rms_m", "RMS over the last ten periods",
                                          document::kMetre};
inline constexpr document::Key kErrorEstimate{"error_estimate", "relative error, at most"};
inline constexpr document::Key kEnergyImbalance{"energy_imbalance",
                                                "remainder of the energy balance"};

/// The numbers of an answer that are neither RMS values nor peaks.
struct MotionNumbers {
  /// Least force between contactor and skin, a stated preload and weight in it; without either,
  /// what preload keeps contact, with a minus.
  std::optional<double> contact_force_least_n;
  std::optional<double> efficiency;  ///< power into the skin's damper over electrical power in
  std::optional<sim::SkinRise> rise;
  std::optional<sim::Finding> no_rise;  ///< why not; nothing where no rise was asked for
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

/// What leaving an effect out, or forcing it on, does to the scene's answer.
struct EffectTrial {
  sim::Effect effect;
  /// Of the asked quantity, relative, between with and without it; infinite where one of them has
  /// no answer.
  double change = 0;
  double with_s = 0;  ///< best time of three runs
  double without_s = 0;
};

/// What an accuracy costs.
struct AccuracyTrial {
  double accuracy = 0;                     ///< run.tolerance
  double seconds = 0;                      ///< best time of three answers
  std::optional<double> error_estimate{};  ///< of the answer; absent: it is refused
  std::int64_t solver_steps = 0;           ///< 0: exact
};

/// The largest error estimate among an answer's numbers.
[[nodiscard]] double ErrorOfAll(const SceneAnswer& answer);

/// Whether that is above the accuracy that the scene requires; never of a chaotic motion, whose
/// averages have an uncertainty of their own.
[[nodiscard]] bool IsAboveAsked(const SceneAnswer& answer);

/// Answers the scene at accuracies of 2, 4, 6, 8 and 10 digits. Cost: fifteen answers; of one that
/// takes more than a second, one each.
[[nodiscard]] std::vector<AccuracyTrial> TryAccuracies(const sim::Scene& scene,
                                                       const std::string& where);

/// Plays the scene with and without each effect whose constants are stated, around its choice.
/// Cost: six runs for each of them.
[[nodiscard]] std::vector<EffectTrial> TryEffects(const sim::Scene& scene,
                                                  const sim::EffectChoice& choice);

}  // namespace haptometer::tools
