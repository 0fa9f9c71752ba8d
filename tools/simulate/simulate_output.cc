#include "tools/simulate/simulate_output.h"

#include <fmt/core.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "tools/cli/json.h"

namespace haptometer::tools {
namespace {

using nlohmann::ordered_json;

std::string StartName(const sim::Scene& scene) {
  return sim::StartOf(scene) == sim::Start::kRest ? "rest" : "steady state";
}

std::string Method(const SimulateAnswer& answer) {
  std::string method = "exact phasor of the linear model";
  if (answer.solved.window) method += "; window by the balanced matrix exponential";
  return method;
}

std::string Bodies(const sim::Scene& scene) {
  return scene.adapter ? "actuator, adapter, skin (7 states)" : "actuator on the skin (5 states)";
}

}  // namespace

std::vector<std::string> SimulateAssumptions(const SimulateAnswer& answer) {
  return {"springs and dampers are linear at any travel: check the mover's against its stops",
          fmt::format("contact is kept whatever the force: it is lost where less than {:.3g} N "
                      "presses actuator and skin together",
                      answer.solved.steady.skin_force_peak_n),
          "the source holds its voltage, and the coil keeps its resistance"};
}

std::string SimulateText(const SimulateAnswer& answer) {
  const sim::SteadyState& steady = answer.solved.steady;
  const double degrees = steady.phase_rad * 180 / std::numbers::pi;
  std::string text =
      fmt::format("{}: {}, {:g} V at {:g} Hz\n", answer.scene_path, Bodies(answer.solved.scene),
                  answer.solved.scene.drive.amplitude_v, answer.solved.scene.drive.frequency_hz);
  text += fmt::format("  skin displacement  {:12.5f} um RMS\n", steady.skin_rms_m * 1e6);
  if (answer.solved.skin_rms_relative_uncertainty > 0) {
    const double half_um = 1.96e6 * answer.solved.skin_rms_relative_uncertainty * steady.skin_rms_m;
    text += fmt::format("                  +- {:12.5f} um (95 %, from the actuator's constants)\n",
                        half_um);
  }
  text += fmt::format("  mover travel    +- {:12.5f} um in its case\n", steady.mover_peak_m * 1e6);
  text += fmt::format("  case displacement  {:12.5f} um RMS\n", steady.case_rms_m * 1e6);
  text += fmt::format("  current            {:12.5f} mA RMS\n", steady.current_rms_a * 1e3);
  text += fmt::format("  phase of current   {:12.5f} degrees to the voltage\n", degrees);
  text += fmt::format("  electrical power   {:12.5f} mW\n", steady.power_w * 1e3);
  text += fmt::format("  skin force      +- {:12.5f} N\n", steady.skin_force_peak_n);
  if (answer.solved.window) {
    text += fmt::format("  from {}, {:.6g} to {:.6g} s (10 periods): skin {:.5f} um RMS\n",
                        StartName(answer.solved.scene), answer.solved.window->begin_s,
                        answer.solved.window->end_s, answer.solved.window->skin_rms_m * 1e6);
  }
  text += fmt::format("  method: {}; relative error of the skin below {:.1e}\n", Method(answer),
                      steady.error_estimate);
  for (const std::string& assumption : SimulateAssumptions(answer)) {
    text += fmt::format("  assumed: {}\n", assumption);
  }
  if (!answer.trial_path.empty()) text += fmt::format("  written: {}\n", answer.trial_path);
  return text;
}

std::string SimulateJson(const SimulateAnswer& answer) {
  const sim::SteadyState& steady = answer.solved.steady;
  ordered_json document{
      {"scene", answer.scene_path},
      {"skin_rms_m", steady.skin_rms_m},
      {"skin_rms_standard_uncertainty_m",
       answer.solved.skin_rms_relative_uncertainty > 0
           ? cli::NumberOrNull(answer.solved.skin_rms_relative_uncertainty * steady.skin_rms_m)
           : ordered_json(nullptr)},
      {"mover_peak_m", steady.mover_peak_m},
      {"case_rms_m", steady.case_rms_m},
      {"current_rms_a", steady.current_rms_a},
      {"power_w", steady.power_w},
      {"phase_rad", steady.phase_rad},
      {"skin_force_peak_n", steady.skin_force_peak_n},
      {"method", Method(answer)},
      {"error_estimate", steady.error_estimate},
      {"window_rms_m", nullptr},
      {"window_s", nullptr},
      {"assumptions", SimulateAssumptions(answer)},
      {"trial", cli::TextOrNull(answer.trial_path)}};
  if (answer.solved.window) {
    document["window_rms_m"] = answer.solved.window->skin_rms_m;
    document["window_s"] = {answer.solved.window->begin_s, answer.solved.window->end_s};
  }
  return cli::JsonText(document);
}

}  // namespace haptometer::tools
