#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <optional>
#include <string>

#include "base/mapped.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/motor_source.h"
#include "sim/linear/steady_state.h"
#include "sim/linear/time_response.h"
#include "tools/reproduce/thesis_model.h"

// Table 2.3: steady displacement under three contact conditions.

namespace haptometer::tools {
namespace {

// the three contacts of Table 2.3
constexpr std::array kKeys{"rms-direct", "rms-cone", "rms-adapter"};
constexpr double kShortRunS = 0.1;
constexpr double kWindowPeriods = 10;

using Three = std::array<double, kKeys.size()>;
using Scenes = std::array<sim::Scene, kKeys.size()>;

Scenes TableScenes(const ThesisModel& model) {
  return {WithoutAdapter(model, kCaseAreaM2), WithoutAdapter(model, kSimulatedConeAreaM2),
          WithAdapter(model, kIa2AreaM2)};
}

// Part of a tone that remains if the drive is interpolated linearly between samples `step_s` apart:
// the spectrum of the triangle, sinc^2(f h). Its images lie at kilohertz, where nothing moves.
double Interpolated(double frequency_hz, double step_s) {
  const double angle = std::numbers::pi * frequency_hz * step_s;
  const double sinc = angle == 0 ? 1 : std::sin(angle) / angle;
  return sinc * sinc;
}

// the step h in s with sinc^2(f h) = part, by bisection; nothing where no step has that part
std::optional<double> StepThatLeaves(double frequency_hz, double part) {
  if (!(part > 0 && part < 1)) return std::nullopt;
  double low = 0;
  double high = 1 / frequency_hz;  // leaves nothing
  for (int halvings = 0; halvings < 60; ++halvings) {
    const double middle = (low + high) / 2;
    (Interpolated(frequency_hz, middle) > part ? low : high) = middle;
  }
  return low;
}

// RMS over a whole run from rest, the drive interpolated linearly
struct SampledRun {
  double duration_s = 0;
  double step_s = 0;
  double worst = std::numeric_limits<double>::infinity();  // largest relative deviation
  Three rms_m{};
};

// the step that minimises the largest deviation of the three; nothing where the part is 1 or more
std::optional<SampledRun> BestStep(double frequency_hz, double duration_s, const Three& rms_m) {
  // printed over computed value: the part that interpolation would have to leave
  Three parts{};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    parts[i] = SiValue(ThesisNumberOf(kKeys[i])) / rms_m[i];
  }
  const auto [least, most] = std::ranges::minmax(parts);
  // harmonic mean: equal largest relative deviations of least and most
  const double part = 2 * least * most / (least + most);
  const auto step_s = StepThatLeaves(frequency_hz, part);
  if (!step_s) return std::nullopt;
  SampledRun run{duration_s, *step_s, part / least - 1, rms_m};
  for (double& rms : run.rms_m) rms *= Interpolated(frequency_hz, *step_s);
  return run;
}

// Of runs from a tenth of a second to two, the one that brings all three nearest to what is
// printed.
std::optional<SampledRun> NearestRun(const Scenes& scenes) {
  constexpr int kTenths = 20;
  std::optional<SampledRun> nearest;
  const auto responses = Mapped<sim::TimeResponse>(scenes, [](const sim::Scene& scene) {
    return sim::TimeResponse(sim::AssembleModel(scene), scene.drive, sim::Start::kRest);
  });
  for (int tenth = 1; tenth <= kTenths; ++tenth) {
    const double duration_s = tenth / 10.0;
    Three rms_m{};
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      // exact RMS over the whole run, transient included
      rms_m[i] = responses[i].WindowRms(sim::AssembleModel(scenes[i]).skin(), 0, duration_s);
    }
    const auto run = BestStep(scenes[0].drive.frequency_hz, duration_s, rms_m);
    if (run && (!nearest || run->worst < nearest->worst)) nearest = run;
  }
  return nearest;
}

// candidate: RMS over the last ten periods of a run of 0.1 s from rest
CandidateCause ShortRun(const sim::Scene& scene) {
  const sim::LinearModel linear = sim::AssembleModel(scene);
  const sim::TimeResponse response(linear, scene.drive, sim::Start::kRest);
  const double begin_s = kShortRunS - kWindowPeriods / scene.drive.frequency_hz;
  return {.text = "the last 10 periods of a run of 0.1 s from rest",
          .gives = response.WindowRms(linear.skin(), begin_s, kShortRunS)};
}

// time in which the slowest natural motion decays to 1e-3: ln(1000) / (decay rate)
std::string SettlingRemark(const sim::Scene& scene) {
  double slowest_per_s = std::numeric_limits<double>::infinity();
  for (const std::complex<double>& pole : sim::Poles(sim::AssembleModel(scene))) {
    slowest_per_s = std::min(slowest_per_s, -pole.real());
  }
  return fmt::format("the slowest pole decays at {:.1f} 1/s: 0.1 % takes {:.2f} s", slowest_per_s,
                     std::log(1e3) / slowest_per_s);
}

ThesisRow RatioRow(const std::vector<ThesisRow>& rows) {
  const double direct = SiValue(ThesisNumberOf(kKeys[0]));
  const double adapter = SiValue(ThesisNumberOf(kKeys[2]));
  return {.key = "ratio-adapter-direct",
          .ours = *rows[2].ours / *rows[0].ours,
          .remark = fmt::format("the printed pair of Table 2.3 gives {:.3f}", adapter / direct)};
}

// the thesis has two values of the largest stiffness; the row states the effect of the choice
std::string RangeRemark(const ThesisModel& model) {
  ThesisModel other = model;
  other.skin_range = sim::SkinRange::kTable;
  return fmt::format("with Ks up to 2000 N/m (text); up to 1200 N/m (Table 2.1) {:.5f} mm",
                     1e3 * sim::SolveSteadyState(WithoutAdapter(other, kCaseAreaM2)).skin_rms_m);
}

}  // namespace

std::vector<ThesisRow> DisplacementRows(const ThesisModel& model) {
  const Scenes scenes = TableScenes(model);
  const auto run = NearestRun(scenes);

  std::vector<ThesisRow> rows;
  rows.reserve(scenes.size() + 1);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    // the answer: RMS in the linear steady state
    ThesisRow row{.key = kKeys[i], .measure = [i](const ThesisModel& m) {
                    return sim::SolveSteadyState(TableScenes(m)[i]).skin_rms_m;
                  }};
    // candidate causes: a short run, then a sampled drive, then rounded inputs
    row.candidates.push_back(ShortRun(scenes[i]));
    if (run) {
      row.candidates.push_back(
          {.text =
               fmt::format("RMS over a whole run of {:g} s from rest, the input interpolated "
                           "linearly between samples {:.2f} ms apart, the run and the step that "
                           "bring all three nearest (within {:.2f} %)",
                           run->duration_s, 1e3 * run->step_s, 100 * run->worst),
           .gives = run->rms_m[i],
           .kind = CauseKind::kTuned});
    }
    rows.push_back(std::move(row));
  }
  Measure(model, &rows);
  // one set of inputs for all three rows
  const auto rounded = FromRoundedInputs(model, rows);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].candidates.push_back(rounded[i]);
  rows.front().remark = RangeRemark(model);
  rows.back().remark = SettlingRemark(scenes.back());
  rows.push_back(RatioRow(rows));
  return rows;
}

// Resonance, impedances (Figure 2.4) and sensitivity (Figure 2.5).
namespace {

// times the drive's frequency; the system's other resonances are outside of the figure
constexpr double kLowestPart = 0.5;
constexpr double kHighestPart = 1.5;

double SkinRmsAt(sim::Scene scene, double frequency_hz) {
  scene.drive.frequency_hz = frequency_hz;
  return sim::SolveSteadyState(scene).skin_rms_m;
}

std::string PolesRemark(const sim::Scene& scene) {
  std::string text = "poles of the assembled system at";
  for (const std::complex<double>& pole : sim::Poles(sim::AssembleModel(scene))) {
    // real poles have no frequency, and of a pair one is enough
    if (pole.imag() <= 0) continue;  // one of a pair
    text += fmt::format(" {:.2f}", std::abs(pole) / (2 * std::numbers::pi));
  }
  return text + " Hz";
}

// f = sqrt(Ka/Ma2) / (2 pi) of the printed values, with the interval of Ma2's last digit
CandidateCause AdapterAlone() {
  const ThesisNumber& mass = ThesisNumberOf("grid-skin-side-mass");
  const double stiffness = SiValue(ThesisNumberOf("grid-stiffness"));
  const auto alone = [&](double steps) {
    const double mass_kg = SiValue(mass) + steps * mass.half_step * mass.unit.si;
    return std::sqrt(stiffness / mass_kg) / (2 * std::numbers::pi);
  };
  return {.text = "sqrt(Ka/Ma2)/2 pi, the adapter alone on a held motor without skin",
          .gives = alone(0),
          .from_rounded = dsp::Interval{alone(1), alone(-1)}};
}

// frequency in Hz of the largest RMS of the skin within 0.5 to 1.5 times the drive's
ThesisRow ResonanceRow(const sim::Scene& scene) {
  const double drive_hz = scene.drive.frequency_hz;
  const double peak_hz = LargestAt([&](double f) { return SkinRmsAt(scene, f); },
                                   kLowestPart * drive_hz, kHighestPart * drive_hz);
  return {.key = "resonant-frequency",
          .ours = peak_hz,
          .candidates = {AdapterAlone()},
          .remark = PolesRemark(scene)};
}

// where driver and skin have impedances of equal magnitude, below and above the dip
std::vector<ThesisRow> ImpedanceRows(const sim::Scene& scene) {
  const double drive_hz = scene.drive.frequency_hz;
  const double low_hz = kLowestPart * drive_hz;
  const double high_hz = kHighestPart * drive_hz;
  // abs(Zd) of actuator and adapter at the skin, N s/m
  const auto driver = [&](double f) { return std::abs(sim::DriverImpedance(scene, f)); };
  const auto ratio = [&](double f) {
    return driver(f) / std::abs(sim::SkinImpedance(scene.skin, f));
  };
  // the dip of abs(Zd) is its resonance, and divides the search into two
  const double dip_hz = LargestAt([&](double f) { return -driver(f); }, low_hz, high_hz);
  const auto excess = [&](double f) { return ratio(f) - 1; };
  const auto below_hz = CrossingOf(excess, low_hz, dip_hz);
  const auto above_hz = CrossingOf(excess, dip_hz, high_hz);
  ThesisRow match{.key = "impedance-match", .ours = below_hz};
  if (above_hz) match.remark = fmt::format("and again at {:.2f} Hz", *above_hz);
  // maximum power transfer: Zd is the conjugate of Zs
  const std::complex<double> z = sim::DriverImpedance(scene, drive_hz);
  return {match,
          {.key = "impedance-dip", .ours = dip_hz},
          {.key = "impedance-ratio",
           .ours = ratio(drive_hz),
           .remark = fmt::format("{:.3f}{:+.3f}j N s/m: nearly the conjugate of the skin's, which "
                                 "is what takes most power",
                                 z.real(), z.imag())}};
}

// largest relative change of the RMS for one of six numbers from -50 % to +50 %
std::vector<ThesisRow> SensitivityRows(const sim::Scene& scene) {
  static constexpr std::array kSensitivityKeys{"sensitivity-Ma1", "sensitivity-Ma2",
                                               "sensitivity-Ka",  "sensitivity-Ba",
                                               "sensitivity-Ks",  "sensitivity-Bs"};
  std::vector<ThesisRow> rows;
  rows.reserve(kSensitivityKeys.size());
  for (std::size_t i = 0; i < kSensitivityKeys.size(); ++i) {
    double most = 0;
    // in steps of 1 %, so that a maximum within the range is found
    for (int percent = -50; percent <= 50; ++percent) {
      const double factor = 1 + percent / 100.0;
      most =
          std::max(most, std::abs(sim::RelativeSkinRms(scene, sim::kSceneNumbers[i], factor) - 1));
    }
    const auto at = [&](double factor) {
      return 100 * (sim::RelativeSkinRms(scene, sim::kSceneNumbers[i], factor) - 1);
    };
    rows.push_back(
        {.key = kSensitivityKeys[i],
         .ours = most,
         .remark = fmt::format("{:+.2f} % at -50 %, {:+.2f} % at +50 %", at(0.5), at(1.5))});
  }
  return rows;
}

}  // namespace

std::vector<ThesisRow> FrequencyRows(const ThesisModel& model) {
  const sim::Scene scene = WithAdapter(model, kIa2AreaM2);
  return Joined({{ResonanceRow(scene)}, ImpedanceRows(scene), SensitivityRows(scene)});
}

// Figure 2.3: displacement over time from rest.
namespace {

// level of the thesis's comparison of the begin of the motion (2.3, p. 20)
constexpr double kEarlyLevelM = 25e-6;
// "full": 90 % of the steady peak
constexpr double kFullPart = 0.9;
constexpr double kErrorsFromS = 25e-3;  // Lindsay 2013, p. 4

// steady peak of the skin in m: sqrt(2) RMS
double PeakOf(const sim::Scene& scene) {
  return std::numbers::sqrt2 * sim::SolveSteadyState(scene).skin_rms_m;
}

std::optional<double> Over(const std::optional<double>& a, const std::optional<double>& b) {
  if (!a || !b) return std::nullopt;
  return *a / *b;
}

std::string Judged(const std::optional<double>& full_s) {
  if (!full_s) return "not reached within 1 s";
  return fmt::format(
      "{} the 25 ms from which latency causes errors (p. 4); the first micrometres come at once",
      *full_s > kErrorsFromS ? "beyond" : "within");
}

// times in s; 1 s (longest run) where the level is not reached
double FullTime(const ThesisModel& model) {
  const sim::Scene adapter = WithAdapter(model, kIa2AreaM2);
  return TimeToReach(adapter, kFullPart * PeakOf(adapter)).value_or(1);
}

double StartRatio(const ThesisModel& model) {
  return Over(TimeToReach(WithAdapter(model, kIa2AreaM2), kEarlyLevelM),
              TimeToReach(WithoutAdapter(model, kCaseAreaM2), kEarlyLevelM))
      .value_or(10);
}

}  // namespace

std::vector<ThesisRow> RiseRows(const ThesisModel& model) {
  const auto [direct, cone, adapter] = TableScenes(model);
  const auto direct_full_s = TimeToReach(direct, kFullPart * PeakOf(direct));
  const auto adapter_full_s = TimeToReach(adapter, kFullPart * PeakOf(adapter));
  const auto direct_s = TimeToReach(direct, kEarlyLevelM);
  const auto cone_s = TimeToReach(cone, kEarlyLevelM);
  const auto adapter_s = TimeToReach(adapter, kEarlyLevelM);
  const std::string full = direct_full_s
                               ? fmt::format("direct at 90 % after {:.2f} ms", 1e3 * *direct_full_s)
                               : std::string();
  std::vector<ThesisRow> rows{
      {.key = "rise-ratio", .ours = Over(adapter_full_s, direct_full_s), .remark = full},
      {.key = "amplitude-ratio", .ours = PeakOf(adapter) / PeakOf(direct)},
      {.key = "start-ratio",
       .ours = Over(adapter_s, direct_s),
       .remark = "the curves are not the same: the heavier skin side starts later",
       .measure = StartRatio},
      {.key = "latency-adapter",
       .ours = adapter_full_s,
       .remark = Judged(adapter_full_s),
       .measure = FullTime},
      {.key = "start-direct", .ours = direct_s},
      {.key = "start-cone", .ours = cone_s},
      {.key = "start-adapter", .ours = adapter_s}};
  ExplainByRounding(model, &rows);
  return rows;
}

}  // namespace haptometer::tools
