#include "tools/simulate/simulate_output.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <numbers>

#include "tools/cli/json.h"
#include "tools/simulate/effect_lines.h"

namespace haptometer::tools {
namespace {

using nlohmann::ordered_json;

std::string StartName(const sim::Scene& scene) {
  return sim::StartOf(scene) == sim::Start::kRest ? "rest" : "steady state";
}

std::string Method(const SceneAnswer& solved) {
  std::vector<std::string> methods;
  if (solved.steady) methods.emplace_back("exact phasor of the linear model");
  const bool smooth = solved.effects && solved.effects->run.solver;
  if (solved.window && !smooth) methods.emplace_back("window by the balanced matrix exponential");
  if (solved.effects && solved.effects->periodic) methods.emplace_back("shooting");
  if (solved.effects && !solved.effects->run.events.empty()) {
    methods.emplace_back("events located to rounding");
  }
  if (smooth) {
    methods.emplace_back(*solved.effects->run.solver == sim::OdeMethod::kBdf
                             ? "SUNDIALS CVODES, BDF"
                             : "SUNDIALS CVODES, Adams");
  }
  return fmt::format("{}", fmt::join(methods, "; "));
}

std::string Bodies(const sim::Scene& scene) {
  return scene.adapter ? "actuator, adapter, skin (7 states)" : "actuator on the skin (5 states)";
}

// what the effects leave to be assumed
bool Limited(const SceneAnswer& solved, sim::Effect effect) {
  return solved.scene.effects[effect] != sim::Wish::kOff;
}

std::string SteadyText(const SceneAnswer& solved) {
  const sim::SteadyState& steady = *solved.steady;
  std::string text = fmt::format("  skin displacement  {:12.5f} um RMS\n", steady.skin_rms_m * 1e6);
  if (solved.skin_rms_relative_uncertainty > 0) {
    const double half_um = 1.96e6 * solved.skin_rms_relative_uncertainty * steady.skin_rms_m;
    text += fmt::format("                  +- {:12.5f} um (95 %, from the actuator's constants)\n",
                        half_um);
  }
  text += fmt::format("  mover travel    +- {:12.5f} um in its case\n", steady.mover_peak_m * 1e6);
  text += fmt::format("  case displacement  {:12.5f} um RMS\n", steady.case_rms_m * 1e6);
  text += fmt::format("  current            {:12.5f} mA RMS\n", steady.current_rms_a * 1e3);
  text += fmt::format("  phase of current   {:12.5f} degrees to the voltage\n",
                      steady.phase_rad * 180 / std::numbers::pi);
  text += fmt::format("  electrical power   {:12.5f} mW\n", steady.power_w * 1e3);
  text += fmt::format("  skin force      +- {:12.5f} N\n", steady.skin_force_peak_n);
  return text;
}

// how the motion repeats itself that a limited scene settles to
std::string PeriodicText(const SceneAnswer& solved) {
  if (!solved.effects->periodic) return {};
  const sim::PeriodicMotion& motion = *solved.effects->periodic;
  return fmt::format(
      "  settles to a motion that repeats itself every {} period{} of the drive; a small deviation "
      "shrinks to {:.2g} of itself each time\n",
      motion.drive_periods, motion.drive_periods == 1 ? "" : "s", std::abs(motion.multipliers(0)));
}

// the run that the effects were decided by
std::string RunText(const SceneAnswer& solved) {
  const sim::SceneRun& run = solved.effects->run;
  std::string text = PeriodicText(solved);
  text += fmt::format(
      "  in the run, {:.6g} to {:.6g} s: skin {:.5f} um RMS, case {:.5f} um RMS, mover +- {:.5f} "
      "um "
      "(whole run {:.5f}), {:.5f} mA RMS, {:.5f} mW\n",
      run.begin_s, run.end_s, run.skin_rms_m * 1e6, run.case_rms_m * 1e6, run.mover_peak_m * 1e6,
      run.mover_peak_of_run_m * 1e6, run.current_rms_a * 1e3, run.power_w * 1e3);
  for (const sim::EventCount& event : run.events) {
    text += fmt::format("  event: {}, {} times, first at {:.9g} s\n", event.name, event.count,
                        event.first_s);
  }
  if (solved.effects->on[sim::PlaceOf(sim::Effect::kCoilHeating)]) {
    text += fmt::format("  coil {:.4f} K warmer at the end, at most {:.4f} K in the run\n",
                        run.temperature_rise_k, run.temperature_peak_k);
  }
  if (run.solver) {
    text += fmt::format("  solver: {} steps, relative error of the run below {:.1e}\n",
                        run.work.steps, run.error_estimate);
  }
  text += fmt::format("  energy of the run closes to {:.1e}\n", run.ledger.Imbalance());
  return text;
}

ordered_json EffectsJson(const SceneAnswer& solved) {
  if (!solved.effects) return nullptr;
  const sim::EffectChoice& choice = *solved.effects;
  ordered_json effects = ordered_json::object();
  for (std::size_t k = 0; k < sim::kEffectNames.size(); ++k) {
    const sim::EffectVerdict& verdict = choice.verdicts[k];
    const bool asked =
        verdict.ground != sim::Ground::kNamed && verdict.ground != sim::Ground::kNotNamed;
    effects[std::string(sim::kEffectNames[k])] = {
        {"on", verdict.on},
        {"why", VerdictText(verdict)},
        {"change", asked ? cli::NumberOrNull(verdict.change) : ordered_json(nullptr)}};
  }
  return effects;
}

ordered_json PeriodicJson(const SceneAnswer& solved) {
  if (!solved.effects || !solved.effects->periodic) return nullptr;
  const sim::PeriodicMotion& motion = *solved.effects->periodic;
  ordered_json multipliers = ordered_json::array();
  for (const auto& multiplier : motion.multipliers) {
    multipliers.push_back({multiplier.real(), multiplier.imag()});
  }
  return {{"drive_periods", motion.drive_periods},
          {"floquet_multipliers", multipliers},
          {"residual", motion.residual}};
}

ordered_json RunJson(const SceneAnswer& solved) {
  if (!solved.effects) return nullptr;
  const sim::SceneRun& run = solved.effects->run;
  ordered_json events = ordered_json::array();
  for (const sim::EventCount& event : run.events) {
    events.push_back({{"name", event.name}, {"count", event.count}, {"first_s", event.first_s}});
  }
  return {{"window_s", {run.begin_s, run.end_s}},
          {"skin_rms_m", run.skin_rms_m},
          {"case_rms_m", run.case_rms_m},
          {"current_rms_a", run.current_rms_a},
          {"power_w", run.power_w},
          {"mover_peak_m", run.mover_peak_m},
          {"mover_peak_of_run_m", run.mover_peak_of_run_m},
          {"temperature_rise_k", run.temperature_rise_k},
          {"temperature_peak_k", run.temperature_peak_k},
          {"error_estimate", run.error_estimate},
          {"solver_steps", run.work.steps},
          {"events", events},
          {"energy_imbalance", run.ledger.Imbalance()}};
}

}  // namespace

std::vector<std::string> SimulateAssumptions(const SimulateAnswer& answer) {
  const SceneAnswer& solved = answer.solved;
  const std::string springs = Limited(solved, sim::Effect::kStiffening)
                                  ? "dampers and the other springs are linear at any travel"
                                  : "springs and dampers are linear at any travel";
  std::vector<std::string> assumptions{
      Limited(solved, sim::Effect::kTravelStops)
          ? springs
          : springs +
                ", and no travel limit is given: this may be impossible; check the mover's "
                "travel against its stops"};
  if (!Limited(solved, sim::Effect::kContactLoss) && solved.steady) {
    assumptions.push_back(
        fmt::format("contact is kept whatever the force: it is lost where less than {:.3g} N "
                    "presses actuator and skin together",
                    solved.steady->skin_force_peak_n));
  }
  assumptions.emplace_back(Limited(solved, sim::Effect::kCoilHeating)
                               ? "the source holds its voltage, and only the coil warms"
                               : "the source holds its voltage, and the coil keeps its resistance");
  return assumptions;
}

std::string SimulateText(const SimulateAnswer& answer) {
  const SceneAnswer& solved = answer.solved;
  std::string text =
      fmt::format("{}: {}, {:g} V at {:g} Hz\n", answer.scene_path, Bodies(solved.scene),
                  solved.scene.drive.amplitude_v, solved.scene.drive.frequency_hz);
  if (solved.steady) {
    text += SteadyText(solved);
  } else if (solved.scene.duration_s) {
    text += "  steady state: not the linear one; searched for without a duration\n";
  }
  if (solved.window) {
    text += fmt::format("  from {}, {:.6g} to {:.6g} s (10 periods): skin {:.5f} um RMS\n",
                        StartName(solved.scene), solved.window->begin_s, solved.window->end_s,
                        solved.window->skin_rms_m * 1e6);
  }
  if (solved.effects) {
    text += RunText(solved);
    for (const std::string& line : EffectLines(solved.scene, *solved.effects)) {
      text += fmt::format("  effect: {}\n", line);
    }
  }
  text += fmt::format("  method: {}", Method(solved));
  if (solved.steady) {
    text += fmt::format("; relative error of the skin below {:.1e}", solved.steady->error_estimate);
  }
  text += "\n" + answer.explanation;
  for (const std::string& assumption : SimulateAssumptions(answer)) {
    text += fmt::format("  assumed: {}\n", assumption);
  }
  if (!answer.trial_path.empty()) text += fmt::format("  written: {}\n", answer.trial_path);
  return text;
}

std::string SimulateJson(const SimulateAnswer& answer) {
  const SceneAnswer& solved = answer.solved;
  const std::optional<sim::SteadyState>& steady = solved.steady;
  const auto number = [&](double sim::SteadyState::* field) -> ordered_json {
    return steady ? cli::NumberOrNull((*steady).*field) : ordered_json(nullptr);
  };
  // what a limited scene settles to has these numbers too
  const auto settled = [&](double sim::SteadyState::* linear,
                           double sim::SceneRun::* limited) -> ordered_json {
    const sim::SceneRun* run = SettledRun(solved);
    return run != nullptr ? cli::NumberOrNull(run->*limited) : number(linear);
  };
  const double relative = solved.skin_rms_relative_uncertainty;
  ordered_json document{
      {"scene", answer.scene_path},
      {"skin_rms_m", settled(&sim::SteadyState::skin_rms_m, &sim::SceneRun::skin_rms_m)},
      {"skin_rms_standard_uncertainty_m", relative > 0 && steady
                                              ? cli::NumberOrNull(relative * steady->skin_rms_m)
                                              : ordered_json(nullptr)},
      {"mover_peak_m", settled(&sim::SteadyState::mover_peak_m, &sim::SceneRun::mover_peak_m)},
      {"case_rms_m", settled(&sim::SteadyState::case_rms_m, &sim::SceneRun::case_rms_m)},
      {"current_rms_a", settled(&sim::SteadyState::current_rms_a, &sim::SceneRun::current_rms_a)},
      {"power_w", settled(&sim::SteadyState::power_w, &sim::SceneRun::power_w)},
      {"phase_rad", number(&sim::SteadyState::phase_rad)},
      {"skin_force_peak_n", number(&sim::SteadyState::skin_force_peak_n)},
      {"method", Method(solved)},
      {"error_estimate", number(&sim::SteadyState::error_estimate)},
      {"window_rms_m", nullptr},
      {"window_s", nullptr},
      {"effects", EffectsJson(solved)},
      {"run", RunJson(solved)},
      {"periodic", PeriodicJson(solved)},
      {"assumptions", SimulateAssumptions(answer)},
      {"trial", cli::TextOrNull(answer.trial_path)}};
  if (solved.window) {
    document["window_rms_m"] = solved.window->skin_rms_m;
    document["window_s"] = {solved.window->begin_s, solved.window->end_s};
  }
  return cli::JsonText(document);
}

}  // namespace haptometer::tools
