#include "tools/simulate/motion_numbers.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "sim/linear/linear_model.h"
#include "sim/linear/scene_mode.h"
#include "sim/period_map.h"
#include "sim/piecewise/piecewise_scene.h"
#include "tools/simulate/drive_text.h"

namespace haptometer::tools {
namespace {

double SkinShare(const sim::EnergyLedger& ledger) {
  return ledger.dissipated_j[static_cast<std::size_t>(sim::SceneElement::kSkin)] / ledger.input_j;
}

std::optional<double> EfficiencyOf(const SceneAnswer& answer) {
  double share = std::nan("");
  if (answer.steady) {
    // without the constant part of the motion
    const Eigen::Index skin = sim::AssembleModel(EffectiveOf(answer).scene).skin();
    const double speed = 2 * std::numbers::pi * answer.scene.drive.frequency_hz *
                         std::abs(answer.steady->phasors(skin)) / std::numbers::sqrt2;
    share = answer.scene.skin.damping_n_s_per_m * speed * speed / answer.steady->power_w;
  } else if (answer.tones) {
    share = answer.tones->skin_power_w / answer.tones->power_w;
  } else if (RunOf(answer) != nullptr) {
    share = SkinShare(RunOf(answer)->ledger);
  }
  return std::isfinite(share) ? std::optional(share) : std::nullopt;
}

std::optional<double> LeastForce(const SceneAnswer& answer, const sim::Waveforms* played) {
  if (const sim::SceneRun* run = RunOf(answer); run != nullptr && !IsSuperposed(answer)) {
    return sim::RestingForceN(EffectiveOf(answer)) + run->skin_force_least_n;
  }
  if (played != nullptr) return played->force_least_n;
  if (answer.scene.duration_s) return std::nullopt;
  const double resting_n = sim::RestingForceN(EffectiveOf(answer));
  // an offset shifts what swings
  const auto least_n = [&](const auto& steady) {
    return resting_n - steady.skin_force_peak_n + std::abs(steady.mean_skin_force_n) +
           steady.mean_skin_force_n;
  };
  if (answer.steady) return least_n(*answer.steady);
  if (answer.tones) return least_n(*answer.tones);
  return std::nullopt;
}

std::optional<sim::SteadyPart> SteadyPartOf(const sim::Scene& scene, double duration_s) {
  const sim::Drive& drive = scene.drive;
  if (drive.kind == sim::DriveKind::kSine) return sim::SteadyPart{.end_s = duration_s};
  if (drive.kind != sim::DriveKind::kBurst) return std::nullopt;
  const double full_s = drive.start_s + drive.rise_s;
  return sim::SteadyPart{.drive_s = drive.start_s,
                         .begin_s = full_s,
                         .end_s = std::min(full_s + drive.hold_s, duration_s)};
}

// Adds the rise, or why there is none.
void AddRise(const sim::Scene& scene, const sim::Waveforms& played, MotionNumbers& numbers) {
  const double duration_s = static_cast<double>(played.rows() - 1) / played.rate_hz;
  const auto part = SteadyPartOf(scene, duration_s);
  if (!part) {
    numbers.no_rise = fmt::format("under {} no amplitude stands still", KindText(scene.drive.kind));
    return;
  }
  if (!sim::LastsForARise(*part, scene.drive.frequency_hz)) {
    numbers.no_rise =
        fmt::format("the drive is on for less than {:g} periods", sim::kLeastRisePeriods);
    return;
  }
  numbers.rise = sim::RiseOf({played.skin_m.data(), static_cast<std::size_t>(played.rows())},
                             played.rate_hz, scene.drive.frequency_hz, *part);
  if (!numbers.rise) numbers.no_rise = "its amplitude does not pass from 10 % to 90 %";
}

}  // namespace

sim::EffectiveScene EffectiveOf(const SceneAnswer& answer) {
  if (answer.effects) return sim::WithEffects(answer.scene, answer.effects->on);
  return {.scene = answer.scene, .piecewise = {}};
}

sim::Beginning StartOf(const SceneAnswer& answer, const sim::EffectiveScene& effective) {
  const bool settled = SettledRun(answer) != nullptr;
  const bool repeats = settled && answer.effects->periodic;
  if (!repeats && !(settled && answer.effects->chaotic)) return sim::BeginningOf(effective);
  const sim::PeriodPoint& point =
      repeats ? answer.effects->periodic->point : answer.effects->chaotic->point;
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
    numbers.no_rise = "the run is too long to be looked at";
  } else {
    AddRise(answer.scene, *played, numbers);
  }
  return numbers;
}

}  // namespace haptometer::tools
