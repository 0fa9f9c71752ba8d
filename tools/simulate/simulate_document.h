#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim/scene/scene.h"
#include "tools/document/document.h"
#include "tools/simulate/scene_answer.h"

namespace haptometer::tools {

/// What simulate notes besides sim's findings.
enum class SimulateFinding : std::uint8_t {
  kOtherSpringsLinear,  ///< beside stops or a stiffening spring
  kMoverPreload,        ///< preload_n, displacement_m; stop where it rests on one
  kSourceHoldsVoltage,  ///< source_resistance_ohm where it has one
  kOnlyCoilWarms,       ///< the same
  kSteadyNotLinear,
  kPeaksAreSums,      ///< of the amplitudes of tones
  kNoWindow,          ///< run_s
  kChaotic,           ///< growth, growth_uncertainty, periods
  kEndVaries,         ///< relative_uncertainty of the window's RMS
  kEndNotKnown,       ///< the run is too short for that
  kKnownUntil,        ///< tolerance, known_until_s
  kErrorAboveAsked,   ///< relative_error, tolerance; of a chirp hold_tolerance
  kDurationOfDrive,   ///< duration_s, drive_s, ring_down_s
  kDurationAssumed,   ///< duration_s: of a trial or of waveforms
  kIdealSensor,       ///< rate_hz
  kWaveformsStalled,  ///< at_s
};

[[nodiscard]] document::Sentence SentenceOf(SimulateFinding kind);

/// The effects of a scene and the cost of its accuracy, as --explain has them.
struct Explanation {
  sim::EffectChoice choice;
  std::vector<EffectTrial> trials;
  std::vector<AccuracyTrial> accuracies;
};

/// Everything that simulate answers.
struct SimulateAnswer {
  std::string scene_path{};
  SceneAnswer solved{};
  MotionNumbers numbers{};
  std::optional<Explanation> explanation{};  ///< absent: not asked for
  std::string trial_path{};                  ///< empty: none written
  std::string waveforms_path{};              ///< empty: none written
  std::string plot_path{};                   ///< empty: none drawn
  std::vector<plot::Panel> panels{};         ///< empty: not asked for
  Findings<SimulateFinding> findings{};      ///< of what was filled in to the question
};

/// The answer as a document.
[[nodiscard]] document::Document SimulateDocument(const SimulateAnswer& answer);

/// Rise and latency of the skin with their verdict, as `rise`.
[[nodiscard]] document::Section RiseSection(const std::optional<sim::SkinRise>& known);

/// "a sine", "tones", "a burst", "a chirp", "a pulse", "samples".
[[nodiscard]] std::string KindText(sim::DriveKind kind);

}  // namespace haptometer::tools
