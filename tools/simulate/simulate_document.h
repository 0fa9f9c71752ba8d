#pragma once

#include <string>
#include <vector>

#include "sim/scene/scene.h"
#include "tools/simulate/scene_answer.h"

namespace haptometer::tools {

/// Everything that simulate answers.
struct SimulateAnswer {
  std::string scene_path;
  SceneAnswer solved;
  MotionNumbers numbers;
  std::string trial_path;        ///< empty: none written
  std::string explanation;       ///< the table of --explain; empty: not asked for
  std::string waveforms_path{};  ///< empty: none written
  std::string plot_path{};       ///< empty: none drawn
};

/// What the numbers rest on, one sentence each.
[[nodiscard]] std::vector<std::string> SimulateAssumptions(const SimulateAnswer& answer);

/// The answer for people, in um, mA, mW and degrees.
[[nodiscard]] std::string SimulateText(const SimulateAnswer& answer);

/// The answer as one JSON document in SI units; what is not known is null.
[[nodiscard]] std::string SimulateJson(const SimulateAnswer& answer);

/// "5 V at 225 Hz", "tones of 1 V at 40 Hz and 2 V at 225 Hz", "a burst of 5 V at 225 Hz from 0 to
/// 0.03 s", with the source's resistance where there is one.
[[nodiscard]] std::string DriveText(const sim::Drive& drive);

/// "a sine", "tones", "a burst", "a chirp", "a pulse", "samples".
[[nodiscard]] std::string KindText(sim::DriveKind kind);

}  // namespace haptometer::tools
