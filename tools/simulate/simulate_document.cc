#include "tools/simulate/simulate_document.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <numbers>

#include "base/text.h"
#include "sim/linear/linear_model.h"
#include "tools/analyze/analysis_document.h"
#include "tools/cli/json.h"
#include "tools/simulate/scene_answer.h"

namespace haptometer::tools {
namespace {

using nlohmann::ordered_json;

std::string StartName(const sim::Scene& scene) {
  if (scene.initial.Any()) return "the stated start";
  return sim::StartOf(scene) == sim::Start::kRest ? "rest" : "steady state";
}

std::string Method(const SceneAnswer& solved) {
  std::vector<std::string> methods;
  if (solved.steady) methods.emplace_back("exact phasor of the linear model");
  if (solved.tones || IsSuperposed(solved)) {
    methods.emplace_back("exact phasors of the linear model, superposed");
  }
  if (solved.plain_run) methods.emplace_back("exact pieces of the drive");
  const bool smooth = solved.effects && solved.effects->run.solver;
  if (solved.window && !smooth) methods.emplace_back("window by the balanced matrix exponential");
  if (solved.effects && solved.effects->periodic) methods.emplace_back("transient and shooting");
  if (solved.effects && solved.effects->chaotic) methods.emplace_back("averages of batches");
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

std::string SourceAssumption(const sim::Drive& drive, bool warms) {
  const std::string_view coil =
      warms ? ", and only the coil warms" : ", and the coil keeps its resistance";
  if (drive.source_resistance_ohm == 0) return fmt::format("the source holds its voltage{}", coil);
  return fmt::format(
      "the source holds its voltage ahead of its {:g} ohm, which power and phase include{}",
      drive.source_resistance_ohm, coil);
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
  if (solved.scene.drive.offset_v == 0) return text;
  return text +
         fmt::format("  of it constant: skin {:.5f} um, mover {:.5f} um in its case, {:.5f} mA\n",
                     steady.mean(sim::AssembleModel(solved.scene).skin()) * 1e6,
                     steady.mean_travel_m * 1e6, steady.mean_current_a * 1e3);
}

std::string TonesText(const sim::SteadyTones& tones) {
  std::string text = fmt::format("  skin displacement  {:12.5f} um RMS\n", tones.skin_rms_m * 1e6);
  text += fmt::format("  mover travel    +- {:12.5f} um in its case\n", tones.mover_peak_m * 1e6);
  text += fmt::format("  case displacement  {:12.5f} um RMS\n", tones.case_rms_m * 1e6);
  text += fmt::format("  current            {:12.5f} mA RMS\n", tones.current_rms_a * 1e3);
  text += fmt::format("  electrical power   {:12.5f} mW\n", tones.power_w * 1e3);
  text += fmt::format("  skin force      +- {:12.5f} N\n", tones.skin_force_peak_n);
  text += tones.period_s > 0
              ? fmt::format("  repeats itself every {:.6g} s, over which travel and force peak\n",
                            tones.period_s)
              : std::string(
                    "  travel and force: at most that, the sums of the tones' amplitudes, "
                    "which have no short common period\n");
  return text;
}

std::string RiseText(const MotionNumbers& numbers) {
  if (!numbers.no_rise.empty()) return fmt::format("  rise: none told, {}\n", numbers.no_rise);
  if (!numbers.rise) return {};
  const sim::SkinRise& rise = *numbers.rise;
  std::string text = "  rise of the skin   ";
  if (rise.rise_s) {
    text += fmt::format("{:12.2f} ms from 10 % to 90 %", *rise.rise_s * 1e3);
  } else if (rise.rise_at_most_s) {
    text += fmt::format("at most {:.2f} ms from 10 % to 90 %", *rise.rise_at_most_s * 1e3);
  } else {
    text += "not determined";
  }
  text += fmt::format(", to {:.2g} ms\n  latency to 10 %    {}: {}\n", rise.uncertainty_s * 1e3,
                      LatencyText(rise), LatencyVerdict(rise));
  return text;
}

// what presses on the skin, where that is not said by a steady amplitude
std::string NumbersText(const SimulateAnswer& answer) {
  const MotionNumbers& numbers = answer.numbers;
  std::string text;
  if (numbers.contact_force_least_n) {
    text += fmt::format("  least contact force{:12.5f} N, preload and weight included{}\n",
                        *numbers.contact_force_least_n,
                        *numbers.contact_force_least_n < 0 ? ": the skin would have to pull" : "");
  }
  if (numbers.efficiency) {
    text += fmt::format("  into the skin      {:12.5f} % of the electrical power\n",
                        *numbers.efficiency * 100);
  }
  return text + RiseText(numbers);
}

// what is known of a motion that never repeats itself
std::string ChaoticText(const sim::ChaoticMotion& motion) {
  return fmt::format(
      "  settles to a chaotic motion: small deviations grow by {:.3g} +- {:.1g} (logarithm, each "
      "period of the drive); RMS values and power are averages over {} periods\n",
      motion.exponent, motion.exponent_standard_uncertainty, motion.periods);
}

// how the end of a run with a duration repeats itself
std::string EndText(const SceneAnswer& solved) {
  if (!solved.effects->end) return {};
  const sim::RunEnd& end = *solved.effects->end;
  if (end.drive_periods) {
    return fmt::format("  the run ends in a motion that repeats itself every {} period{}\n",
                       *end.drive_periods, *end.drive_periods == 1 ? "" : "s");
  }
  if (!end.window_uncertainty) {
    return "  the run's end does not repeat itself, and the run is too short to tell what its "
           "window is uncertain by\n";
  }
  return fmt::format(
      "  the run's end does not repeat itself: its window's RMS is uncertain by {:.2g} of itself "
      "(standard deviation from window to window)\n",
      *end.window_uncertainty);
}

// how the motion repeats itself that a limited scene settles to
std::string PeriodicText(const SceneAnswer& solved) {
  if (!solved.effects) return {};
  if (solved.effects->chaotic) return ChaoticText(*solved.effects->chaotic);
  if (!solved.effects->periodic) return EndText(solved);
  const sim::PeriodicMotion& motion = *solved.effects->periodic;
  std::string text =
      fmt::format("  settles to a motion that repeats itself every {} period{} of the drive",
                  motion.drive_periods, motion.drive_periods == 1 ? "" : "s");
  if (motion.multipliers.size() > 0) {
    text += fmt::format("; a small deviation shrinks to {:.2g} of itself each time",
                        std::abs(motion.multipliers(0)));
  }
  return text + "\n";
}

// the run that was played
std::string RunText(const SceneAnswer& solved) {
  const sim::SceneRun& run = *RunOf(solved);
  std::string text = PeriodicText(solved);
  const std::string when =
      IsSuperposed(solved) ? "over a long time"
                           : fmt::format("in the run, {:.6g} to {:.6g} s", run.begin_s, run.end_s);
  text += fmt::format(
      "  {}: skin {:.5f} um RMS, case {:.5f} um RMS, mover +- {:.5f} um{}, {:.5f} mA RMS, {:.5f} "
      "mW\n",
      when, run.skin_rms_m * 1e6, run.case_rms_m * 1e6, run.mover_peak_m * 1e6,
      run.begin_s > 0 ? fmt::format(" (whole run {:.5f})", run.mover_peak_of_run_m * 1e6) : "",
      run.current_rms_a * 1e3, run.power_w * 1e3);
  for (const sim::EventCount& event : run.events) {
    text += fmt::format("  event: {}, {} times, first at {:.9g} s\n", event.name, event.count,
                        event.first_s);
  }
  if (solved.effects && solved.effects->on[sim::PlaceOf(sim::Effect::kCoilHeating)]) {
    text += fmt::format("  coil {:.4f} K warmer at the end, at most {:.4f} K in the run\n",
                        run.temperature_rise_k, run.temperature_peak_k);
  }
  if (run.solver) text += fmt::format("  solver: {} steps\n", run.work.steps);
  if (run.known_until_s) {
    text += fmt::format("  known to {:g} until {:.6g} s: small errors grow in this motion\n",
                        solved.scene.tolerance, *run.known_until_s);
  }
  text += fmt::format("  energy of the run closes to {:.1e}\n", run.ledger.Imbalance());
  return text;
}

// of all that is answered
double ErrorEstimate(const SceneAnswer& solved) {
  double largest = 0;
  if (solved.steady) largest = solved.steady->error_estimate;
  if (solved.tones) largest = std::max(largest, solved.tones->error_estimate);
  if (const sim::SceneRun* run = RunOf(solved)) largest = std::max(largest, run->error_estimate);
  return largest;
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

ordered_json AverageJson(const SceneAnswer& solved) {
  if (!solved.effects || !solved.effects->chaotic) return nullptr;
  const sim::ChaoticMotion& motion = *solved.effects->chaotic;
  const sim::SceneRun& run = solved.effects->run;
  const Eigen::Index skin = sim::AssembleModel(EffectiveOf(solved).scene).skin();
  const sim::PeriodMeans& uncertain = motion.standard_uncertainties;
  const auto of_rms = [&](double rms, Eigen::Index state) {
    return cli::NumberOrNull(uncertain.mean_squares(state) / (2 * rms));
  };
  return {{"drive_periods", motion.periods},
          {"lyapunov_exponent_per_period", motion.exponent},
          {"lyapunov_exponent_standard_uncertainty", motion.exponent_standard_uncertainty},
          {"skin_rms_standard_uncertainty_m", of_rms(run.skin_rms_m, skin)},
          {"case_rms_standard_uncertainty_m", of_rms(run.case_rms_m, sim::LinearModel::kCase)},
          {"power_standard_uncertainty_w", uncertain.power_w}};
}

ordered_json RiseJson(const MotionNumbers& numbers) {
  if (!numbers.rise) return nullptr;
  const sim::SkinRise& rise = *numbers.rise;
  return {{"rise_s", cli::NumberOrNull(rise.rise_s)},
          {"rise_at_most_s", cli::NumberOrNull(rise.rise_at_most_s)},
          {"latency_s", rise.latency_s},
          {"latency_below_s", cli::NumberOrNull(LatencyBelowS(rise))},
          {"standard_uncertainty_s", rise.uncertainty_s},
          {"verdict", LatencyVerdict(rise)}};
}

ordered_json RunJson(const SceneAnswer& solved) {
  if (RunOf(solved) == nullptr) return nullptr;
  const sim::SceneRun& run = *RunOf(solved);
  ordered_json events = ordered_json::array();
  for (const sim::EventCount& event : run.events) {
    events.push_back({{"name", event.name}, {"count", event.count}, {"first_s", event.first_s}});
  }
  // how its end repeats itself, or what its window is uncertain by
  ordered_json repeats = nullptr, uncertain = nullptr;
  if (solved.effects && solved.effects->end) {
    const sim::RunEnd& end = *solved.effects->end;
    if (end.drive_periods) repeats = *end.drive_periods;
    if (end.window_uncertainty) uncertain = cli::NumberOrNull(*end.window_uncertainty);
  }
  return {{"window_s", {run.begin_s, run.end_s}},
          {"drive_periods", repeats},
          {"window_relative_uncertainty", uncertain},
          {"skin_rms_m", run.skin_rms_m},
          {"case_rms_m", run.case_rms_m},
          {"current_rms_a", run.current_rms_a},
          {"power_w", run.power_w},
          {"mover_peak_m", run.mover_peak_m},
          {"mover_peak_of_run_m", run.mover_peak_of_run_m},
          {"temperature_rise_k", run.temperature_rise_k},
          {"temperature_peak_k", run.temperature_peak_k},
          {"error_estimate", run.error_estimate},
          {"known_until_s", cli::NumberOrNull(run.known_until_s)},
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
  if (!Limited(solved, sim::Effect::kContactLoss) && (solved.steady || solved.tones)) {
    assumptions.push_back(fmt::format(
        "contact is kept whatever the force: it is lost where less than {:.3g} N presses actuator "
        "and skin together",
        solved.steady ? solved.steady->skin_force_peak_n : solved.tones->skin_force_peak_n));
  }
  if (const double preload_n = solved.scene.mover_preload_n; preload_n != 0) {
    const sim::EffectiveScene effective = EffectiveOf(solved);
    const double sag_m = sim::MoverSag(solved.scene, Limited(solved, sim::Effect::kGravity),
                                       effective.smooth.spring.has_value());
    assumptions.push_back(fmt::format(
        "{:g} N act on the mover, towards the skin positive; positions count from static "
        "equilibrium, where they hold it {:.5f} um from where its spring is at ease{}",
        preload_n, sag_m * 1e6,
        sim::RestsOnStop(effective) ? ", beyond the stop that it therefore rests on" : ""));
  }
  assumptions.push_back(
      SourceAssumption(solved.scene.drive, Limited(solved, sim::Effect::kCoilHeating)));
  return assumptions;
}

std::string SimulateText(const SimulateAnswer& answer) {
  const SceneAnswer& solved = answer.solved;
  std::string text = fmt::format("{}: {}, {}\n", Printable(answer.scene_path), Bodies(solved.scene),
                                 DriveText(solved.scene.drive));
  const bool is_sine = solved.scene.drive.kind == sim::DriveKind::kSine;
  if (solved.steady) {
    text += SteadyText(solved);
  } else if (solved.tones) {
    text += TonesText(*solved.tones);
  } else if (is_sine && solved.scene.duration_s) {
    text += "  steady state: not the linear one; searched for without a duration\n";
  }
  if (solved.window) {
    text += fmt::format("  from {}, {:.6g} to {:.6g} s (10 periods): skin {:.5f} um RMS\n",
                        StartName(solved.scene), solved.window->begin_s, solved.window->end_s,
                        solved.window->skin_rms_m * 1e6);
  }
  if (RunOf(solved) != nullptr) text += RunText(solved);
  text += NumbersText(answer);
  // the explanation has them too
  if (solved.effects && answer.explanation.empty()) {
    for (const std::string& line : EffectLines(solved.scene, *solved.effects)) {
      text += fmt::format("  effect: {}\n", line);
    }
  }
  text += fmt::format("  method: {}", Method(solved));
  text += fmt::format("; relative error of all numbers below {:.1e}", ErrorEstimate(solved));
  text += "\n" + answer.explanation;
  for (const std::string& assumption : SimulateAssumptions(answer)) {
    text += fmt::format("  assumed: {}\n", assumption);
  }
  for (const std::string& path : {answer.trial_path, answer.waveforms_path, answer.plot_path}) {
    if (!path.empty()) text += fmt::format("  written: {}\n", Printable(path));
  }
  return text;
}

std::string SimulateJson(const SimulateAnswer& answer) {
  const SceneAnswer& solved = answer.solved;
  const std::optional<sim::SteadyState>& steady = solved.steady;
  const std::optional<sim::SteadyTones>& tones = solved.tones;
  const auto number = [&](double sim::SteadyState::* field,
                          double sim::SteadyTones::* of_tones) -> ordered_json {
    if (tones) return cli::NumberOrNull((*tones).*of_tones);
    return steady ? cli::NumberOrNull((*steady).*field) : ordered_json(nullptr);
  };
  // what a limited scene settles to has these numbers too
  const auto settled = [&](double sim::SteadyState::* linear, double sim::SteadyTones::* of_tones,
                           double sim::SceneRun::* limited) -> ordered_json {
    const sim::SceneRun* run = SettledRun(solved);
    return run != nullptr ? cli::NumberOrNull(run->*limited) : number(linear, of_tones);
  };
  using State = sim::SteadyState;
  using Tones = sim::SteadyTones;
  using Run = sim::SceneRun;
  const double relative = solved.skin_rms_relative_uncertainty;
  ordered_json document{
      {"scene", answer.scene_path},
      {"skin_rms_m", settled(&State::skin_rms_m, &Tones::skin_rms_m, &Run::skin_rms_m)},
      {"skin_rms_standard_uncertainty_m", relative > 0 && steady
                                              ? cli::NumberOrNull(relative * steady->skin_rms_m)
                                              : ordered_json(nullptr)},
      {"mover_peak_m", settled(&State::mover_peak_m, &Tones::mover_peak_m, &Run::mover_peak_m)},
      {"case_rms_m", settled(&State::case_rms_m, &Tones::case_rms_m, &Run::case_rms_m)},
      {"current_rms_a", settled(&State::current_rms_a, &Tones::current_rms_a, &Run::current_rms_a)},
      {"power_w", settled(&State::power_w, &Tones::power_w, &Run::power_w)},
      {"phase_rad", steady ? cli::NumberOrNull(steady->phase_rad) : ordered_json(nullptr)},
      {"skin_force_peak_n", number(&State::skin_force_peak_n, &Tones::skin_force_peak_n)},
      {"contact_force_least_n", cli::NumberOrNull(answer.numbers.contact_force_least_n)},
      {"efficiency", cli::NumberOrNull(answer.numbers.efficiency)},
      {"rise", RiseJson(answer.numbers)},
      {"period_s",
       tones && tones->period_s > 0 ? cli::NumberOrNull(tones->period_s) : ordered_json(nullptr)},
      {"method", Method(solved)},
      {"error_estimate", cli::NumberOrNull(ErrorEstimate(solved))},
      {"window_rms_m", nullptr},
      {"window_s", nullptr},
      {"effects", EffectsJson(solved)},
      {"run", RunJson(solved)},
      {"periodic", PeriodicJson(solved)},
      {"average", AverageJson(solved)},
      {"assumptions", SimulateAssumptions(answer)},
      {"trial", cli::TextOrNull(answer.trial_path)},
      {"waveforms", cli::TextOrNull(answer.waveforms_path)},
      {"plot", cli::TextOrNull(answer.plot_path)}};
  if (solved.window) {
    document["window_rms_m"] = solved.window->skin_rms_m;
    document["window_s"] = {solved.window->begin_s, solved.window->end_s};
  }
  return cli::JsonText(document);
}

namespace {

// the tones one after the other
std::string DriveTonesText(const sim::Drive& drive) {
  std::string text = "tones of ";
  for (std::size_t k = 0; k < drive.tones.size(); ++k) {
    const bool is_last = k + 1 == drive.tones.size();
    if (k > 0) text += is_last ? " and " : ", ";
    text += fmt::format("{:g} V at {:g} Hz", drive.tones[k].amplitude, drive.tones[k].frequency_hz);
  }
  return text;
}

std::string KindPlays(const sim::Drive& drive) {
  const std::string when =
      fmt::format("from {:g} to {:g} s", drive.start_s, sim::EndOfDriveS(drive));
  switch (drive.kind) {
    case sim::DriveKind::kSine:
      return fmt::format("{:g} V at {:g} Hz", drive.amplitude_v, drive.frequency_hz);
    case sim::DriveKind::kTones:
      return DriveTonesText(drive);
    case sim::DriveKind::kBurst:
      return fmt::format("a burst of {:g} V at {:g} Hz {}", drive.amplitude_v, drive.frequency_hz,
                         when);
    case sim::DriveKind::kChirp:
      return fmt::format("a chirp of {:g} V, {:g} to {:g} Hz {}", drive.amplitude_v,
                         drive.frequency_hz, drive.end_frequency_hz, when);
    case sim::DriveKind::kPulse:
      return fmt::format("a pulse of {:g} V {}", drive.amplitude_v, when);
    case sim::DriveKind::kSamples:
      return fmt::format("{} voltages at {:g} Hz, up to {:g} V", drive.samples->voltages_v.size(),
                         drive.samples->rate_hz, sim::LargestVoltageV(drive));
  }
  return {};
}

std::string WhatItPlays(const sim::Drive& drive) {
  if (drive.offset_v == 0) return KindPlays(drive);
  return fmt::format("{} on an offset of {:g} V", KindPlays(drive), drive.offset_v);
}

}  // namespace

std::string DriveText(const sim::Drive& drive) {
  if (drive.source_resistance_ohm == 0) return WhatItPlays(drive);
  return fmt::format("{} through {:g} ohm", WhatItPlays(drive), drive.source_resistance_ohm);
}

std::string KindText(sim::DriveKind kind) {
  const bool is_plural = kind == sim::DriveKind::kTones || kind == sim::DriveKind::kSamples;
  return fmt::format("{}{}", is_plural ? "" : "a ", Name(kind));
}

}  // namespace haptometer::tools
