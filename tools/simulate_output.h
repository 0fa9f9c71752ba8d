#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/scene.h"
#include "sim/steady_state.h"

namespace haptometer::tools {

/// RMS of the skin over the last ten periods of a run.
struct WindowAnswer {
  double begin_s = 0;
  double end_s = 0;
  double skin_rms_m = 0;
};

/// Everything that simulate answers.
struct SimulateAnswer {
  std::string scene_path;
  sim::Scene scene;
  sim::SteadyState steady;
  double skin_rms_relative_uncertainty = 0;  ///< from the actuator's; 0: stated as exact
  std::optional<WindowAnswer> window;        ///< with a duration of at least ten periods
  std::string trial_path;                    ///< empty: none written
};

/// What the numbers rest on, one sentence each.
[[nodiscard]] std::vector<std::string> SimulateAssumptions(const SimulateAnswer& answer);

/// The answer for people, in um, mA, mW and degrees.
[[nodiscard]] std::string SimulateText(const SimulateAnswer& answer);

/// The answer as one JSON document in SI units; what is not known is null.
[[nodiscard]] std::string SimulateJson(const SimulateAnswer& answer);

}  // namespace haptometer::tools
