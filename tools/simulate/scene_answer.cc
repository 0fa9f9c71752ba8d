#include "tools/simulate/scene_answer.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>
#include <vector>

#include "sim/effective_scene.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/time_response.h"
#include "sim/piecewise/piecewise_scene.h"
#include "tools/simulate/drive_text.h"

namespace haptometer::tools {
namespace {

constexpr double kWindowPeriods = 10;

// The last ten periods of the run, where it has as many.
std::optional<WindowAnswer> AnswerWindow(const sim::Scene& scene) {
  if (!scene.duration_s) return std::nullopt;
  const double length_s = kWindowPeriods / scene.drive.frequency_hz;
  // a run of exactly ten periods may miss them by a rounding
  const double begin_s = *scene.duration_s - length_s;
  if (begin_s < -1e-12 * length_s) return std::nullopt;
  if (scene.drive.offset_v != 0 || scene.initial.Any()) {
    const sim::SceneRun run = sim::RunScene({.scene = scene, .piecewise = {}}, *scene.duration_s);
    return WindowAnswer{.begin_s = run.begin_s, .end_s = run.end_s, .skin_rms_m = run.skin_rms_m};
  }
  const sim::LinearModel model = sim::AssembleModel(scene);
  const sim::TimeResponse response(model, scene.drive, sim::StartOf(scene));
  WindowAnswer window{.begin_s = std::max(0.0, begin_s), .end_s = *scene.duration_s};
  window.skin_rms_m = response.WindowRms(model.skin(), window.begin_s, window.end_s);
  return window;
}

std::optional<WindowAnswer> WindowOf(const SceneAnswer& answer) {
  if (!answer.effects) return AnswerWindow(answer.scene);
  const sim::SceneRun& run = answer.effects->run;
  const double length_s = kWindowPeriods / answer.scene.drive.frequency_hz;
  if (!answer.scene.duration_s || run.end_s - run.begin_s < length_s * (1 - 1e-9)) return {};
  if (answer.effects->end) {
    // the run's numbers may be of other whole periods
    return WindowAnswer{.begin_s = run.end_s - length_s,
                        .end_s = run.end_s,
                        .skin_rms_m = answer.effects->end->ten_periods_rms_m};
  }
  return WindowAnswer{.begin_s = run.begin_s, .end_s = run.end_s, .skin_rms_m = run.skin_rms_m};
}

// why a steady state does not answer
Error NoSteadyState(const sim::Scene& scene, const std::string& where) {
  if (scene.drive.offset_v != 0 && !sim::IsHeldInPlace(scene)) {
    return {Cause::kCannotAnswer, where,
            "has no steady state: a constant voltage moves bodies that no spring holds in place",
            "give [skin] a stiffness, or a duration and start = \"rest\""};
  }
  constexpr double kClose = 1e-6;  // relative: what damps a resonance is far more
  std::vector<double> frequencies_hz{scene.drive.frequency_hz};
  if (scene.drive.kind == sim::DriveKind::kTones) {
    frequencies_hz.clear();
    for (const sim::Tone& tone : scene.drive.tones) frequencies_hz.push_back(tone.frequency_hz);
  }
  const auto poles = sim::Poles(sim::AssembleModel(scene));
  for (const double frequency_hz : frequencies_hz) {
    const std::complex<double> drive(0, 2 * std::numbers::pi * frequency_hz);
    const bool meets = std::ranges::any_of(poles, [&](const std::complex<double>& pole) {
      return std::abs(pole - drive) <= kClose * std::abs(drive);
    });
    if (!meets) continue;
    return {Cause::kCannotAnswer, where,
            "has no steady state: the drive meets an undamped resonance",
            "add damping or change frequency_hz"};
  }
  const double lowest_hz = *std::ranges::min_element(frequencies_hz);
  return {Cause::kCannotAnswer, where,
          fmt::format("at {:g} Hz the skin moves so little that rounding hides it", lowest_hz),
          "raise frequency_hz"};
}

// whether a run can be played; of a drive that is no sine, whether there is one
Result<void> CheckRun(const sim::Scene& scene, const std::string& where) {
  const bool is_sine = scene.drive.kind == sim::DriveKind::kSine;
  if (!is_sine && !scene.duration_s) {
    return CannotAnswer(
        where, fmt::format("drives with {} and has no duration", KindText(scene.drive.kind)),
        "give duration_s in [run], or --duration");
  }
  const double duration_s = scene.duration_s.value_or(0);
  const double steps = scene.duration_s ? sim::StepsOfRun(scene, duration_s) : 0;
  if (!(steps > sim::MostSteps(scene))) return {};
  return CannotAnswer(where, fmt::format("{:g} s are {:.2g} steps", duration_s, steps),
                      fmt::format("shorten duration_s to {:.3g} s or less",
                                  duration_s * sim::MostSteps(scene) / steps));
}

Result<SceneAnswer> AnswerTones(SceneAnswer answer, const std::string& where) {
  answer.tones = sim::SolveSteadyTones(answer.scene);
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
  if (asks) {
    auto choice = DecideEffects(scene, where);
    if (!choice) return std::unexpected(choice.error());
    answer.effects = std::move(*choice);
    return answer;
  }
  if (auto check = CheckRun(scene, where); !check) return std::unexpected(check.error());
  if (sim::StartOf(scene) == sim::Start::kSteady &&
      !(sim::SolveSteadyTones(scene).error_estimate < 1)) {
    return std::unexpected(NoSteadyState(scene, where));
  }
  answer.plain_run = sim::RunScene({.scene = scene, .piecewise = {}}, *scene.duration_s);
  return answer;
}

}  // namespace

const sim::SceneRun* RunOf(const SceneAnswer& answer) {
  if (answer.effects) return &answer.effects->run;
  return answer.plain_run ? &*answer.plain_run : nullptr;
}

const sim::SceneRun* SettledRun(const SceneAnswer& answer) {
  const bool settled = !answer.scene.duration_s && answer.effects && !answer.steady;
  return settled ? &answer.effects->run : nullptr;
}

bool IsSuperposed(const SceneAnswer& answer) {
  return !answer.steady && SettledRun(answer) != nullptr && !answer.effects->periodic &&
         !answer.effects->chaotic;
}

Result<sim::EffectChoice> DecideEffects(const sim::Scene& scene, const std::string& where) {
  if (auto check = CheckRun(scene, where); !check) return std::unexpected(check.error());
  if (scene.drive.kind != sim::DriveKind::kSine && sim::StartOf(scene) == sim::Start::kSteady) {
    return CannotAnswer(where,
                        "begins with effects in the steady motion of tones, which is not "
                        "searched for",
                        "write start = \"rest\" in [run], and a longer duration_s");
  }
  return sim::ChooseEffects(scene, where);
}

Result<SceneAnswer> AnswerScene(const sim::Scene& scene, const std::string& where) {
  SceneAnswer answer;
  answer.scene = scene;
  if (scene.drive.kind != sim::DriveKind::kSine) return AnswerRun(std::move(answer), where);
  const sim::SteadyState linear = sim::SolveSteadyState(scene);
  if (!(linear.error_estimate < 1)) return std::unexpected(NoSteadyState(scene, where));
  answer.steady = linear;
  if (scene.effects.Asked()) {
    auto choice = DecideEffects(scene, where);
    if (!choice) return std::unexpected(choice.error());
    const sim::EffectiveScene effective = sim::WithEffects(scene, choice->on);
    answer.steady = sim::SolveSteadyState(effective.scene);
    // the transient from the start may lead to a limited motion beside a free one
    const bool limited = choice->periodic || choice->chaotic;
    if (limited || !sim::SteadyMotionIsFree(effective, *answer.steady)) answer.steady.reset();
    answer.effects = std::move(*choice);
  }
  if (answer.steady) answer.skin_rms_relative_uncertainty = sim::SkinRmsUncertainty(scene);
  answer.window = WindowOf(answer);
  return answer;
}

}  // namespace haptometer::tools
