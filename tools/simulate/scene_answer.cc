#include "tools/simulate/scene_answer.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <complex>
#include <cstddef>
#include <iterator>
#include <numbers>
#include <string_view>
#include <utility>

#include "sim/effective_scene.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/scene_mode.h"
#include "sim/linear/window_rms.h"
#include "sim/period_map.h"
#include "sim/piecewise/piecewise_scene.h"
#include "sim/scene_run.h"
#include "tools/simulate/simulate_document.h"
#include "tools/simulate/simulated_trial.h"

namespace haptometer::tools {
namespace {

// RMS over the last ten periods of the run, where it is as long
std::optional<WindowAnswer> AnswerWindow(const sim::Scene& scene) {
  if (!scene.duration_s) return std::nullopt;
  const double length_s = kWindowPeriods / scene.drive.frequency_hz;
  // a run of exactly ten periods may miss them by a rounding
  const double begin_s = *scene.duration_s - length_s;
  if (begin_s < -1e-12 * length_s) return std::nullopt;
  // the window counts back from the end: of a long run its begin as a double has lost digits
  const auto end_s = static_cast<long double>(*scene.duration_s);
  const long double periods_s =
      static_cast<long double>(kWindowPeriods) / static_cast<long double>(scene.drive.frequency_hz);
  const sim::WindowRms window =
      sim::WindowRmsOf(sim::LinearMotionOf(scene), sim::AssembleModel(scene).skin(),
                       std::max(0.0L, end_s - periods_s), end_s);
  return WindowAnswer{.begin_s = std::max(0.0, begin_s),
                      .end_s = *scene.duration_s,
                      .skin_rms_m = window.rms,
                      .error_estimate = window.error_estimate};
}

std::optional<WindowAnswer> WindowOf(const SceneAnswer& answer) {
  if (!answer.effects) return AnswerWindow(answer.scene);
  const sim::SceneRun& run = answer.effects->run;
  const double length_s = kWindowPeriods / answer.scene.drive.frequency_hz;
  // a run with effects whose window is shorter than ten periods by more than rounding has none
  if (!answer.scene.duration_s || run.end_s - run.begin_s < length_s * (1 - 1e-9)) return {};
  if (answer.effects->end) {
    // the run's numbers may be of other whole periods
    return WindowAnswer{.begin_s = run.end_s - length_s,
                        .end_s = run.end_s,
                        .skin_rms_m = answer.effects->end->ten_periods_rms_m,
                        .error_estimate = run.error_estimate};
  }
  return WindowAnswer{.begin_s = run.begin_s,
                      .end_s = run.end_s,
                      .skin_rms_m = run.skin_rms_m,
                      .error_estimate = run.error_estimate};
}

// why the linear scene has no steady state: no spring, an undamped resonance, or rounding
Error NoSteadyState(const sim::Scene& scene, const std::string& where) {
  if (scene.drive.offset_v != 0 && !sim::IsHeldInPlace(scene)) {
    return {Cause::kCannotAnswer, where,
            "has no steady state: a constant voltage moves bodies that no spring holds in place",
            "give [skin] a stiffness, or a duration and start = \"rest\""};
  }
  constexpr double kClose = 1e-6;  // relative: what damps a resonance is far more
  // frequencies of the drive in Hz: one, or one per tone
  std::vector<double> frequencies_hz{scene.drive.frequency_hz};
  if (scene.drive.kind == sim::DriveKind::kTones) {
    frequencies_hz.clear();
    for (const sim::Tone& tone : scene.drive.tones) frequencies_hz.push_back(tone.frequency_hz);
  }
  const auto poles = sim::Poles(sim::AssembleModel(scene));
  for (const double frequency_hz : frequencies_hz) {
    // drive at s = j w in rad/s; an undamped pole lies on the imaginary axis
    const std::complex<double> drive(0, 2 * std::numbers::pi * frequency_hz);
    const bool meets = std::ranges::any_of(poles, [&](const std::complex<double>& pole) {
      return std::abs(pole - drive) <= kClose * std::abs(drive);
    });
    if (!meets) continue;
    return {Cause::kCannotAnswer, where,
            "has no steady state: the drive meets an undamped resonance",
            "add damping or change frequency_hz"};
  }
  // neither: the motion is so small that its rounding exceeds it, first at the lowest frequency
  const double lowest_hz = *std::ranges::min_element(frequencies_hz);
  return {Cause::kCannotAnswer, where,
          fmt::format("at {:g} Hz the skin moves so little that rounding exceeds it", lowest_hz),
          "raise frequency_hz"};
}

// whether a run can be played; of a drive that is no sine, whether there is one
Result<void> CheckRun(const sim::Scene& scene, const std::string& where) {
  const bool is_sine = scene.drive.kind == sim::DriveKind::kSine;
  if (!is_sine && !scene.duration_s) {
    return CannotAnswer(
        where, fmt::format("drives with {} and has no duration", KindText(scene.drive.kind)),
        "give duration_s in [run]");
  }
  const double duration_s = scene.duration_s.value_or(0);
  const double steps = scene.duration_s ? sim::StepsOfRun(scene, duration_s) : 0;
  // the number of steps is limited, so that a long run is refused and not begun
  if (!(steps > sim::MostSteps(scene))) return {};
  return CannotAnswer(where, fmt::format("{:g} s are {:.2g} steps", duration_s, steps),
                      fmt::format("shorten duration_s to {:.3g} s or less",
                                  duration_s * sim::MostSteps(scene) / steps));
}

Result<SceneAnswer> AnswerTones(SceneAnswer answer, const std::string& where) {
  answer.tones = sim::SolveSteadyTones(answer.scene);
  // an error estimate of 1 or more: no steady state exists
  if (answer.tones->error_estimate < 1) return answer;
  return std::unexpected(NoSteadyState(answer.scene, where));
}

// under a drive that is no sine
Result<SceneAnswer> AnswerRun(SceneAnswer answer, const std::string& where) {
  const sim::Scene& scene = answer.scene;
  const bool asks = scene.effects.Asked();
  if (scene.drive.kind == sim::DriveKind::kTones && !scene.duration_s && !asks) {
    return AnswerTones(std::move(answer), where);
  }
  // effects need a run: it decides which of them act
  if (asks) {
    HAPTOMETER_LET(answer.effects, DecideEffects(scene, where));
    if (scene.drive.kind == sim::DriveKind::kSine) answer.window = WindowOf(answer);
    return answer;
  }
  HAPTOMETER_TRY(CheckRun(scene, where));
  // a run from the steady state requires that one exists
  if (sim::StartOf(scene) == sim::Start::kSteady &&
      !(sim::SolveSteadyTones(scene).error_estimate < 1)) {
    return std::unexpected(NoSteadyState(scene, where));
  }
  answer.plain_run = sim::RunScene({.scene = scene, .piecewise = {}}, *scene.duration_s);
  return answer;
}

// part of the power or energy put in that the skin dissipates, 0 to 1
std::optional<double> EfficiencyOf(const SceneAnswer& answer) {
  double share = std::nan("");
  if (answer.steady) {
    // without the constant part of the motion
    const Eigen::Index skin = sim::AssembleModel(EffectiveOf(answer).scene).skin();
    // RMS speed in m/s: w abs(X) / sqrt(2), X the peak phasor of the skin
    const double speed = 2 * std::numbers::pi * answer.scene.drive.frequency_hz *
                         std::abs(answer.steady->phasors(skin)) / std::numbers::sqrt2;
    // mean power Bs v^2 over the input power
    share = answer.scene.skin.damping_n_s_per_m * speed * speed / answer.steady->power_w;
  } else if (answer.tones) {
    share = answer.tones->skin_power_w / answer.tones->power_w;
  } else if (IsSuperposed(answer)) {
    // over all time: the run is a part of the tremor's period
    const sim::SteadyTones motion = sim::Superpose(EffectiveOf(answer).scene);
    share = motion.skin_power_w / motion.power_w;
  } else if (const sim::SceneRun* run = RunOf(answer)) {
    constexpr auto kSkin = static_cast<std::size_t>(sim::SceneElement::kSkin);
    share = run->ledger.dissipated_j[kSkin] / run->ledger.input_j;
  }
  return std::isfinite(share) ? std::optional(share) : std::nullopt;
}

// least force on the contact in N; below 0 the contact would break
std::optional<double> LeastForce(const SceneAnswer& answer, const sim::Waveforms* played) {
  // of a run: static force plus the least dynamic force
  if (const sim::SceneRun* run = RunOf(answer)) {
    const double least_n = sim::RestingForceN(EffectiveOf(answer)) + run->skin_force_least_n;
    // the skin does not pull where contact may break
    return answer.scene.effects.contact_loss ? std::max(0.0, least_n) : least_n;
  }
  if (played != nullptr) return played->force_least_n;
  if (answer.scene.duration_s) return std::nullopt;
  // of a linear steady state: static force plus the least dynamic force
  const double resting_n = sim::RestingForceN(EffectiveOf(answer));
  if (answer.steady) return resting_n + answer.steady->skin_force_least_n;
  if (answer.tones) return resting_n + answer.tones->skin_force_least_n;
  return std::nullopt;
}

// part of the run in which the amplitude of the drive is constant; nothing without one
std::optional<sim::SteadyPart> SteadyPartOf(const sim::Scene& scene, double duration_s) {
  const sim::Drive& drive = scene.drive;
  if (drive.kind == sim::DriveKind::kSine) return sim::SteadyPart{.end_s = duration_s};
  if (drive.kind != sim::DriveKind::kBurst) return std::nullopt;
  const double full_s = drive.start_s + drive.rise_s;
  return sim::SteadyPart{.drive_s = drive.start_s,
                         .begin_s = full_s,
                         .end_s = std::min(full_s + drive.hold_s, duration_s)};
}

sim::Finding NoRise(sim::FindingKind why, FindingNumber number) {
  return {Severity::kNote, why, {std::move(number)}};
}

// adds the rise of the skin's motion, or why there is none
void AddRise(const sim::Scene& scene, const sim::Waveforms& played, MotionNumbers& numbers) {
  const double duration_s = static_cast<double>(played.rows() - 1) / played.rate_hz;
  const auto part = SteadyPartOf(scene, duration_s);
  if (!part) {
    numbers.no_rise = NoRise(sim::FindingKind::kDriveVaries, {"drive", KindText(scene.drive.kind)});
    return;
  }
  // the rise is measured on whole periods, so a short drive determines none
  if (!sim::LastsForARise(*part, scene.drive.frequency_hz)) {
    numbers.no_rise =
        NoRise(sim::FindingKind::kDriveShort, {"least_periods", sim::kLeastRisePeriods});
    return;
  }
  numbers.rise = sim::RiseOf({played.skin_m.data(), static_cast<std::size_t>(played.rows())},
                             played.rate_hz, scene.drive.frequency_hz, *part);
  if (!numbers.rise) numbers.no_rise = NoRise(sim::FindingKind::kNoRise, {"run_s", duration_s});
}

using Number = std::optional<double>;

// a number of the linear steady state; nothing where that does not hold
template <auto kOf>
Number Steady(const SceneAnswer& answer) {
  return answer.steady ? Number(kOf(*answer.steady)) : std::nullopt;
}

// the same, or of the steady state under tones
template <auto kOf>
Number SteadyOrTones(const SceneAnswer& answer) {
  return answer.tones ? Number(kOf(*answer.tones)) : Steady<kOf>(answer);
}

// the same, or of the steady motion of a scene that stops, lost contact or smooth effects limit
template <auto kOf>
Number Settled(const SceneAnswer& answer) {
  const sim::SceneRun* settled = SettledRun(answer);
  return settled != nullptr ? Number(kOf(*settled)) : SteadyOrTones<kOf>(answer);
}

// a number of the run of a scene with effects, or under a drive that is no sine
template <auto kOf>
Number OfRun(const SceneAnswer& answer) {
  const sim::SceneRun* run = RunOf(answer);
  return run != nullptr ? Number(kOf(*run)) : std::nullopt;
}

// of a steady state, one under tones, or a run
constexpr auto kSkinRmsOf = [](const auto& motion) { return motion.skin_rms_m; };
constexpr auto kMoverPeakOf = [](const auto& motion) { return motion.mover_peak_m; };
constexpr auto kCaseRmsOf = [](const auto& motion) { return motion.case_rms_m; };
constexpr auto kCurrentRmsOf = [](const auto& motion) { return motion.current_rms_a; };
constexpr auto kPowerOf = [](const auto& motion) { return motion.power_w; };
constexpr auto kPhaseOf = [](const auto& motion) { return motion.phase_rad; };
constexpr auto kForceOf = [](const auto& motion) { return motion.skin_force_peak_n; };
constexpr auto kMoverPeakOfRunOf = [](const auto& run) { return run.mover_peak_of_run_m; };

constexpr auto kSteadyNumbers = std::to_array<AnswerNumber>({
    {document::kSkinRms, Settled<kSkinRmsOf>},
    {document::kMoverPeak, Settled<kMoverPeakOf>},
    {kCaseRms, Settled<kCaseRmsOf>},
    {document::kCurrentRms, Settled<kCurrentRmsOf>},
    {document::kPower, Settled<kPowerOf>},
    {document::kPhase, Steady<kPhaseOf>},
    {document::kSkinForcePeak, SteadyOrTones<kForceOf>},
});

constexpr auto kRunNumbers = std::to_array<AnswerNumber>({
    {document::kSkinRms, OfRun<kSkinRmsOf>},
    {kCaseRms, OfRun<kCaseRmsOf>},
    {document::kCurrentRms, OfRun<kCurrentRmsOf>},
    {document::kPower, OfRun<kPowerOf>},
    {document::kMoverPeak, OfRun<kMoverPeakOf>},
    {document::Key{"mover_peak_of_run_m", "mover travel in the whole run", document::kMetre},
     OfRun<kMoverPeakOfRunOf>},
});

constexpr int kTimedRuns = 3;

bool HasConstants(const sim::Scene& scene, sim::Effect effect) {
  switch (effect) {
    case sim::Effect::kInductance:
      return scene.actuator.inductance_h > 0;
    case sim::Effect::kGravity:
      return scene.effects[effect] != sim::Wish::kOff;
    case sim::Effect::kTravelStops:
      return scene.effects.travel_stops.has_value();
    case sim::Effect::kContactLoss:
      return scene.effects.contact_loss.has_value();
    case sim::Effect::kStiffening:
      return scene.effects.stiffening.has_value();
    case sim::Effect::kTremor:
      return !scene.finger.tones.empty();
    case sim::Effect::kCoilHeating:
      return scene.effects.coil_heating.has_value();
  }
  return false;
}

struct TimedRun {
  sim::PlayedScene played;
  double seconds = HUGE_VAL;
};

TimedRun BestRun(const sim::Scene& scene, sim::EffectSet on) {
  TimedRun timed;
  for (int k = 0; k < kTimedRuns; ++k) {
    const auto begin = std::chrono::steady_clock::now();
    timed.played = sim::PlayWith(scene, on);
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
    timed.seconds = std::min(timed.seconds, taken.count());
  }
  return timed;
}

}  // namespace

const sim::SceneRun* RunOf(const SceneAnswer& answer) {
  if (answer.effects) return &answer.effects->run;
  return answer.plain_run ? &*answer.plain_run : nullptr;
}

const sim::SceneRun* SettledRun(const SceneAnswer& answer) {
  // without a duration, where the linear steady motion does not hold
  const bool settled = !answer.scene.duration_s && answer.effects && !answer.steady;
  return settled ? &answer.effects->run : nullptr;
}

bool IsSuperposed(const SceneAnswer& answer) {
  return !answer.steady && SettledRun(answer) != nullptr && !answer.effects->periodic &&
         !answer.effects->chaotic;
}

Result<sim::EffectChoice> DecideEffects(const sim::Scene& scene, const std::string& where) {
  HAPTOMETER_TRY(CheckRun(scene, where));
  // period and attractor are searched for a sine only
  if (scene.drive.kind != sim::DriveKind::kSine && sim::StartOf(scene) == sim::Start::kSteady) {
    return CannotAnswer(where,
                        "begins with effects in the steady motion of tones, which is not "
                        "searched for",
                        "write start = \"rest\" in [run], and a longer duration_s");
  }
  auto choice = sim::ChooseEffects(scene);
  if (!choice) return CannotAnswer(where, document::WordsOf(choice.error()));
  return *std::move(choice);
}

Result<SceneAnswer> AnswerScene(const sim::Scene& scene, const std::string& where) {
  SceneAnswer answer;
  answer.scene = scene;
  if (scene.drive.kind != sim::DriveKind::kSine) return AnswerRun(std::move(answer), where);
  // X = (j w I - A)^-1 B V, refused where the bound of its error is 1 or more
  const sim::SteadyState linear = sim::SolveSteadyState(scene);
  if (!(linear.error_estimate < 1)) {
    // a run from rest needs none
    const bool runs = scene.duration_s && sim::StartOf(scene) == sim::Start::kRest;
    if (runs) return AnswerRun(std::move(answer), where);
    return std::unexpected(NoSteadyState(scene, where));
  }
  answer.steady = linear;
  // effects: the scene with those that act is solved again, and the limits are checked
  if (scene.effects.Asked()) {
    HAPTOMETER_LET(auto choice, DecideEffects(scene, where));
    const sim::EffectiveScene effective = sim::WithEffects(scene, choice.on);
    answer.steady = sim::SolveSteadyState(effective.scene);
    // a motion with limits and one without may both exist: the transient from the start decides
    const bool limited = choice.periodic || choice.chaotic;
    if (limited || !sim::SteadyMotionIsFree(effective, *answer.steady)) answer.steady.reset();
    answer.effects = std::move(choice);
  }
  answer.window = WindowOf(answer);
  return answer;
}

sim::EffectiveScene EffectiveOf(const SceneAnswer& answer) {
  if (answer.effects) return sim::WithEffects(answer.scene, answer.effects->on);
  return {.scene = answer.scene, .piecewise = {}};
}

sim::Beginning StartOf(const SceneAnswer& answer, const sim::EffectiveScene& effective) {
  const bool settled = SettledRun(answer) != nullptr;
  // the run starts from a point of the periodic or chaotic motion
  const bool repeats = settled && answer.effects->periodic;
  if (!repeats && !(settled && answer.effects->chaotic)) return sim::BeginningOf(effective);
  const sim::PeriodPoint& point =
      repeats ? answer.effects->periodic->point : answer.effects->chaotic->point;
  // the point is one of the period's map: it is expanded to a full state
  const sim::PeriodMap map(sim::AssemblePiecewise(effective.scene, effective.piecewise),
                           effective.scene.drive);
  // the coil's temperature is a point's last coordinate
  const double rise_k = effective.smooth.heating ? point.x(point.x.size() - 1) : 0;
  return {.start = map.StartOf(point), .temperature_rise_k = rise_k};
}

MotionNumbers NumbersOf(const SceneAnswer& answer, const sim::Waveforms* played) {
  MotionNumbers numbers;
  numbers.contact_force_least_n = LeastForce(answer, played);
  numbers.efficiency = EfficiencyOf(answer);
  const bool rises = answer.scene.duration_s && sim::StartOf(answer.scene) == sim::Start::kRest;
  if (!rises) return numbers;
  if (played == nullptr) {
    numbers.no_rise = NoRise(sim::FindingKind::kRunTooLong, {"run_s", *answer.scene.duration_s});
  } else {
    AddRise(answer.scene, *played, numbers);
  }
  return numbers;
}

std::optional<sim::Waveforms> PlayedMotion(const SceneAnswer& answer) {
  constexpr double kPlayedPeriods = 8;
  if (!answer.scene.duration_s && SettledRun(answer) == nullptr) return std::nullopt;
  const sim::EffectiveScene effective = EffectiveOf(answer);
  const double rate_hz = effective.RateHz();
  const double duration_s =
      answer.scene.duration_s.value_or(kPlayedPeriods / effective.scene.drive.frequency_hz);
  if (!(duration_s * rate_hz >= 1 && duration_s * rate_hz <= kMostWaveformRows)) {
    return std::nullopt;
  }
  return sim::PlayWaveforms(effective, StartOf(answer, effective), duration_s, rate_hz, true);
}

std::span<const AnswerNumber> SteadyNumbers() { return kSteadyNumbers; }

std::span<const AnswerNumber> RunNumbers() { return kRunNumbers; }

double ErrorOfAll(const SceneAnswer& answer) {
  double largest = 0;
  if (answer.steady) largest = answer.steady->error_estimate;
  if (answer.tones) largest = std::max(largest, answer.tones->error_estimate);
  if (answer.window) largest = std::max(largest, answer.window->error_estimate);
  if (const sim::SceneRun* run = RunOf(answer)) largest = std::max(largest, run->error_estimate);
  return largest;
}

bool IsAboveAsked(const SceneAnswer& answer) {
  const sim::Scene& scene = answer.scene;
  if (answer.effects && answer.effects->chaotic) return false;
  // a chirp has a tolerance of its own, which is enough where none is required
  const bool is_required = scene.tolerance != sim::Scene{}.tolerance;
  const double granted = is_required ? 0 : sim::DriveError(scene);
  return ErrorOfAll(answer) - granted > scene.tolerance;
}

std::vector<AccuracyTrial> TryAccuracies(const sim::Scene& scene, const std::string& where) {
  constexpr double kLongS = 1;
  std::vector<AccuracyTrial> trials;
  for (const double accuracy : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10}) {
    sim::Scene asked = scene;
    asked.tolerance = accuracy;
    AccuracyTrial& trial = trials.emplace_back(AccuracyTrial{.accuracy = accuracy});
    trial.seconds = HUGE_VAL;
    for (int k = 0; k < kTimedRuns; ++k) {
      const auto begin = std::chrono::steady_clock::now();
      const auto answer = AnswerScene(asked, where);
      const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
      trial.seconds = std::min(trial.seconds, taken.count());
      if (answer) {
        trial.error_estimate = ErrorOfAll(*answer);
        const sim::SceneRun* run = RunOf(*answer);
        if (run != nullptr) trial.solver_steps = run->work.steps;
      }
      if (taken.count() > kLongS) break;
    }
  }
  return trials;
}

std::vector<EffectTrial> TryEffects(const sim::Scene& scene, const sim::EffectChoice& choice) {
  std::vector<EffectTrial> trials;
  for (std::size_t k = 0; k < sim::kEffectNames.size(); ++k) {
    const auto effect = static_cast<sim::Effect>(k);
    if (!HasConstants(scene, effect)) continue;
    sim::EffectSet on = choice.on;
    // an effect that the scene does not name may leave it without a position of rest
    if (!sim::CanRest(sim::WithEffects(scene, on.set(k)))) continue;
    if (!sim::CanRest(sim::WithEffects(scene, on.reset(k)))) continue;
    const TimedRun with = BestRun(scene, on.set(k));
    const TimedRun without = BestRun(scene, on.reset(k));
    const bool known = with.played.answered && without.played.answered;
    trials.push_back(
        {.effect = effect,
         .change =
             known ? sim::Deviation(scene.quantity, without.played.run, with.played.run) : HUGE_VAL,
         .with_s = with.seconds,
         .without_s = without.seconds});
  }
  return trials;
}

}  // namespace haptometer::tools
