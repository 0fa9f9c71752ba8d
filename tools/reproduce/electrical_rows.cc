// Current, power and phase at the terminals, and what the adapter saves of them.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "sim/linear/linear_model.h"
#include "sim/linear/scene_mode.h"
#include "sim/linear/steady_state.h"
#include "sim/piecewise/piecewise_motion.h"
#include "sim/piecewise/piecewise_scene.h"
#include "tools/reproduce/rounded_inputs.h"
#include "tools/reproduce/row_groups.h"

namespace haptometer::tools {
namespace {

// runs from rest that are looked at as a cause of the printed savings
constexpr double kTunedRunS = 0.085;
constexpr std::array kRunsS{kTunedRunS, 0.1};
constexpr double kOutputHz = 1e4;

// The steady motion when equation 2.3 is taken as it is printed: without the coil's reaction on the
// case, which matrix 2.5 has.
sim::SteadyState WithoutReaction(const sim::Scene& scene) {
  sim::LinearModel linear = sim::AssembleModel(scene);
  const double reaction = scene.actuator.force_constant_n_per_a / sim::CaseSideMass(scene);
  linear.a.row(sim::LinearModel::kCaseVelocity) -= reaction * linear.current_row;
  linear.b(sim::LinearModel::kCaseVelocity) -= reaction * linear.current_per_volt;
  return sim::SolveSteadyState(linear, scene.drive, scene.skin);
}

// energies of a whole run from rest, exact
sim::EnergyLedger RunEnergies(sim::Scene scene, double duration_s) {
  scene.start = sim::Start::kRest;
  sim::PiecewiseMotion motion(sim::AssemblePiecewise(scene, {}), scene.drive,
                              sim::PiecewiseStartOf(scene), kOutputHz, true);
  const auto outputs = static_cast<std::uint64_t>(std::llround(duration_s * kOutputHz));
  while (motion.index() < outputs) motion.Next();
  return motion.Ledger();
}

// RMS, by what the coil dissipates: R integral of i^2
double RunCurrent(const sim::Scene& scene, double duration_s) {
  const auto coil = static_cast<std::size_t>(sim::SceneElement::kCoil);
  const double dissipated_j = RunEnergies(scene, duration_s).dissipated_j[coil];
  return std::sqrt(dissipated_j / (scene.actuator.resistance_ohm * duration_s));
}

// mean of v i
double RunPower(const sim::Scene& scene, double duration_s) {
  return RunEnergies(scene, duration_s).input_j / duration_s;
}

// Saved over whole runs from rest. How long the thesis ran is not printed: the first length is the
// one that gives its 15 %, and Table 2.3 asks for another (0.7 s, displacement_rows.cc).
template <typename Measure>
std::vector<CandidateCause> WholeRuns(const sim::Scene& adapter, const sim::Scene& direct,
                                      const Measure& measure) {
  std::vector<CandidateCause> causes;
  causes.reserve(kRunsS.size());
  for (const double duration_s : kRunsS) {
    causes.push_back(
        {.text = fmt::format("averages over a whole run of {:g} s from rest", duration_s),
         .gives = 1 - measure(adapter, duration_s) / measure(direct, duration_s),
         .kind = duration_s == kTunedRunS ? CauseKind::kTuned : CauseKind::kReading});
  }
  return causes;
}

std::string Both(std::string_view what, double cone, double adapter, std::string_view unit) {
  return fmt::format("{} of the cone {:.2f} {}, with adapter {:.2f} {}", what, cone, unit, adapter,
                     unit);
}

sim::SteadyState DirectState(const ThesisModel& model) {
  return sim::SolveSteadyState(WithoutAdapter(model, kCaseAreaM2));
}

sim::SteadyState AdapterState(const ThesisModel& model) {
  return sim::SolveSteadyState(WithAdapter(model, kIa2AreaM2));
}

// the numbers of the rows below, each for itself: the text mixes two contacts
std::vector<RowMeasure> TerminalMeasures() {
  return {{"current", [](const ThesisModel& m) { return DirectState(m).current_rms_a; }},
          {"power", [](const ThesisModel& m) { return DirectState(m).power_w; }},
          {"phase", [](const ThesisModel& m) { return std::abs(DirectState(m).phase_rad); }},
          {"current-reduction",
           [](const ThesisModel& m) {
             return 1 - AdapterState(m).current_rms_a / DirectState(m).current_rms_a;
           }},
          {"power-reduction", [](const ThesisModel& m) {
             return 1 - AdapterState(m).power_w / DirectState(m).power_w;
           }}};
}

}  // namespace

std::vector<ThesisRow> ElectricalRows(const ThesisModel& model) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  const sim::Scene direct = WithoutAdapter(model, kCaseAreaM2);
  const sim::Scene cone = WithoutAdapter(model, kSimulatedConeAreaM2);
  const sim::Scene adapter = WithAdapter(model, kIa2AreaM2);
  const sim::SteadyState d = sim::SolveSteadyState(direct);
  const sim::SteadyState c = sim::SolveSteadyState(cone);
  const sim::SteadyState a = sim::SolveSteadyState(adapter);
  constexpr auto kOfCone = "of the cone, not of the LRA on the skin: the text has both before it";
  const double unreacted = std::abs(WithoutReaction(direct).phase_rad);
  const double cone_current_a = WithoutReaction(cone).current_rms_a;
  std::vector<ThesisRow> rows{
      {.key = "current",
       .ours = d.current_rms_a,
       .candidates = {{.text = kOfCone, .gives = c.current_rms_a}},
       .remark = Both("direct;", 1e3 * c.current_rms_a, 1e3 * a.current_rms_a, "mA")},
      {.key = "power",
       .ours = d.power_w,
       .candidates = {{.text = kOfCone, .gives = c.power_w},
                      {.text = "R i^2 of the cone with equation 2.3 as printed, without the coil's "
                               "reaction on the case",
                       .gives = model.actuator.resistance_ohm * cone_current_a * cone_current_a}},
       .remark = Both("direct;", 1e3 * c.power_w, 1e3 * a.power_w, "mW")},
      {.key = "phase",
       .ours = std::abs(d.phase_rad),
       .candidates = {{.text = "equation 2.3 as printed, without the coil's reaction on the case",
                       .gives = unreacted}},
       .remark = Both("direct; the current lags;", kDegrees * std::abs(c.phase_rad),
                      kDegrees * std::abs(a.phase_rad), "deg")},
      {.key = "current-reduction",
       .ours = 1 - a.current_rms_a / d.current_rms_a,
       .candidates = WholeRuns(adapter, direct, RunCurrent),
       .remark =
           fmt::format("against the cone {:.1f} %", 100 * (1 - a.current_rms_a / c.current_rms_a))},
      {.key = "power-reduction",
       .ours = 1 - a.power_w / d.power_w,
       .candidates = WholeRuns(adapter, direct, RunPower),
       .remark = fmt::format("against the cone {:.1f} %", 100 * (1 - a.power_w / c.power_w))}};
  ExplainByRounding(model, TerminalMeasures(), &rows);
  return rows;
}

}  // namespace haptometer::tools
