#pragma once

#include <string>
#include <vector>

#include "tools/simulate/motion_numbers.h"
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

}  // namespace haptometer::tools
