#include "sim/effective_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include "base/circular_functions.h"
#include "base/elementary_functions.h"
#include "base/error.h"
#include "sim/linear/excitation.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/scene_mode.h"
#include "sim/scene_run.h"

namespace haptometer::sim {
namespace {

// least rate, outputs per period of an own frequency, its limit (sim/effective_scene.h)
constexpr double kLeastRateHz = 1000;
constexpr double kOutputsPerRinging = 16;
constexpr double kHighestOwnHz = 1e5;
// outputs of a run that are all kept
constexpr double kMostKeptSteps = 1e7;
// amplitude ratio at the end of a ring-down
constexpr double kRungDown = 1e-3;
// a pole that decays less than this part of the fastest one is rounding
constexpr double kNoDecay = 1e-13;

// highest abs(Im p) / 2 pi of the poles, or the finger's highest tone, Hz
double HighestOwnHz(const Scene& scene) {
  double highest_hz = 0;
  for (const auto& pole : Poles(AssembleModel(scene))) {
    highest_hz = std::max(highest_hz, std::abs(pole.imag()) / (2 * std::numbers::pi));
  }
  for (const Tone& tone : scene.finger.tones) highest_hz = std::max(highest_hz, tone.frequency_hz);
  return std::min(highest_hz, kHighestOwnHz);
}

// rate of the pieces of a drive that is held in equal ones; 0 of others
double PiecesHz(const Drive& drive) {
  if (drive.kind == DriveKind::kSamples) return drive.samples->rate_hz;
  return drive.kind == DriveKind::kChirp ? CubicsOf(drive) / drive.duration_s : 0;
}

}  // namespace

double OutputRateHz(const Scene& scene) {
  const Drive& drive = scene.drive;
  if (drive.kind == DriveKind::kSine) {
    // whole multiples of 64 f, so that each period ends at an output
    const double period_hz = kOutputsPerPeriod * drive.frequency_hz;
    if (!scene.duration_s) return period_hz;
    const double ringing_hz = kOutputsPerRinging * HighestOwnHz(scene);
    return period_hz * std::max(1.0, std::ceil(ringing_hz / period_hz));
  }
  const double highest_hz = std::max(HighestFrequencyHz(drive), HighestOwnHz(scene));
  const double rate_hz = std::max(kLeastRateHz, kOutputsPerPeriod * highest_hz);
  const double pieces_hz = PiecesHz(drive);
  // pieces that end at outputs need no split steps; the allowance is for a ratio that is whole
  return pieces_hz > 0 ? pieces_hz * std::ceil(rate_hz / pieces_hz * (1 - 1e-12)) : rate_hz;
}

double StepsOfRun(const Scene& scene, double duration_s) {
  return duration_s * OutputRateHz(scene);
}

double MostSteps(const Scene& scene) {
  return scene.drive.kind == DriveKind::kSine ? kMostOutputs : kMostKeptSteps;
}

std::optional<double> RingDownS(const Scene& scene) {
  const std::vector<std::complex<double>> poles = Poles(AssembleModel(scene));
  double slowest_per_s = HUGE_VAL;
  for (const auto& pole : poles) slowest_per_s = std::min(slowest_per_s, -pole.real());
  // undamped to rounding: it never ends
  if (!(slowest_per_s > kNoDecay * Abs(poles.back()))) return std::nullopt;
  // ln(1000) / min abs(Re p), s
  return -Log(kRungDown) / slowest_per_s;
}

double MoverSag(const Scene& scene, bool gravity, bool stiffening) {
  const double weight_n =
      scene.mover_preload_n +
      (gravity ? scene.actuator.moving_mass_kg * scene.effects.gravity_m_per_s2 : 0);
  const bool hardens = stiffening && scene.effects.stiffening;
  return SagUnder(weight_n, scene.actuator.stiffness_n_per_m,
                  hardens ? scene.effects.stiffening->cubic_n_per_m3 : 0);
}

double PressOnSkin(const Scene& scene, bool gravity) {
  if (scene.grip.holds) return 0;
  return scene.mover_preload_n + (gravity ? Weight(scene) : 0);
}

double Weight(const Scene& scene) {
  if (scene.grip.holds) return 0;
  const double adapter_kg = scene.adapter ? scene.adapter->skin_side_mass_kg : 0;
  return scene.effects.gravity_m_per_s2 *
         (scene.actuator.moving_mass_kg + CaseSideMass(scene) + adapter_kg);
}

EffectiveScene WithEffects(const Scene& scene, EffectSet on) {
  // every choice of effects has the outputs of the stated scene, so that runs can be compared
  EffectiveScene effective{.scene = scene, .piecewise = {}, .outputs_rate_hz = OutputRateHz(scene)};
  const Effects& effects = scene.effects;
  if (!on[PlaceOf(Effect::kInductance)]) effective.scene.actuator.inductance_h = 0;
  if (!on[PlaceOf(Effect::kTremor)]) effective.scene.finger.tones.clear();
  const bool gravity = on[PlaceOf(Effect::kGravity)];
  const bool stiffening = on[PlaceOf(Effect::kStiffening)];
  const double sag_m = MoverSag(scene, gravity, stiffening);
  if (stiffening) {
    HAPTOMETER_CHECK(effects.stiffening.has_value(), "no spring");
    effective.smooth.spring.emplace(*effects.stiffening).sag_m = sag_m;
  }
  if (on[PlaceOf(Effect::kCoilHeating)]) {
    HAPTOMETER_CHECK(effects.coil_heating.has_value(), "no heat capacity");
    effective.smooth.heating = effects.coil_heating;
  }
  if (on[PlaceOf(Effect::kTravelStops)]) {
    HAPTOMETER_CHECK(effects.travel_stops.has_value(), "no stops");
    TravelStops& stops = effective.piecewise.stops.emplace(*effects.travel_stops);
    // positions count from static equilibrium, which is sag_m nearer to the upper stop
    stops.gap_up_m -= sag_m;
    stops.gap_down_m += sag_m;
  }
  if (on[PlaceOf(Effect::kContactLoss)]) {
    HAPTOMETER_CHECK(effects.contact_loss.has_value(), "no preload");
    ContactLoss& loss = effective.piecewise.contact_loss.emplace(*effects.contact_loss);
    // the weight and the mover's preload press in addition
    loss.preload_n += PressOnSkin(scene, gravity);
  }
  return effective;
}

namespace {

// Penetration in m of the pad that holds the mover at `gap_m` < 0 from equilibrium: k p is equal
// to the spring's force there. Newton's method begins where the spring stiffens least.
double DepthAtRest(const EffectiveScene& scene, const TravelStops& stops, int side, double gap_m) {
  constexpr int kMostSteps = 100;
  const double Kv = scene.scene.actuator.stiffness_n_per_m;
  const StiffeningSpring spring = scene.smooth.spring.value_or(StiffeningSpring{});
  // the linear spring's penetration, k p = -Kv (gap + p)
  double depth_m = -Kv * gap_m / (stops.stiffness_n_per_m + Kv);
  for (int k = 0; k < kMostSteps; ++k) {
    const double travel_m = side * (gap_m + depth_m);
    const double over_n =
        stops.stiffness_n_per_m * depth_m + side * (Kv * travel_m + spring.Force(travel_m));
    const double step_m = over_n / (stops.stiffness_n_per_m + Kv + spring.Stiffness(travel_m));
    depth_m -= step_m;
    if (!(std::abs(step_m) > 1e-16 * std::abs(depth_m))) break;
  }
  return depth_m;
}

// a start in mode 0 at a stop, mapped to the mode in which that stop holds it
PiecewiseStart HeldAt(const EffectiveScene& scene, int side, PiecewiseStart start) {
  const TravelStops& stops = *scene.piecewise.stops;
  const double gap_m = side > 0 ? stops.gap_up_m : stops.gap_down_m;
  const PiecewiseLinearSystem system = AssemblePiecewise(scene.scene, scene.piecewise);
  const std::string_view name =
      stops.rigid() ? (side > 0 ? "rest up" : "rest down") : (side > 0 ? "stop up" : "stop down");
  const auto way = std::ranges::find(system.transitions, name, &Transition::name);
  HAPTOMETER_CHECK(way != system.transitions.end(), "no transition {}", name);
  start.x(LinearModel::kMover) = start.x(LinearModel::kCase) + side * gap_m;
  start.x = (way->map * start.x + way->shift).eval();
  start.mode = way->mode;
  // a compliant stop carries the force at a penetration above 0
  if (!stops.rigid()) start.x(LinearModel::kMover) = DepthAtRest(scene, stops, side, gap_m);
  return start;
}

}  // namespace

bool RestsOnStop(const EffectiveScene& scene) {
  const auto& stops = scene.piecewise.stops;
  return stops && std::min(stops->gap_up_m, stops->gap_down_m) <= 0;
}

PiecewiseStart StartIn(const EffectiveScene& scene) {
  PiecewiseStart start = PiecewiseStartOf(scene.scene);
  const bool stated = scene.scene.initial.mover_m != 0 || scene.scene.initial.case_m != 0;
  if (StartOf(scene.scene) != Start::kRest || stated || !RestsOnStop(scene)) return start;
  return HeldAt(scene, scene.piecewise.stops->gap_up_m <= 0 ? 1 : -1, std::move(start));
}

bool CanRest(const EffectiveScene& scene) {
  const auto& loss = scene.piecewise.contact_loss;
  const Skin& skin = scene.scene.skin;
  return !loss ||
         (loss->preload_n > 0 && (skin.stiffness_n_per_m > 0 || skin.damping_n_s_per_m > 0));
}

namespace {

// the amplitude of the travel around its constant part, in both directions, and the least force
struct Reach {
  double travel_m = 0, mean_travel_m = 0;
  double skin_force_least_n = 0;
};

bool IsFree(const EffectiveScene& scene, const Reach& reach, double error) {
  const auto& [stops, loss] = scene.piecewise;
  // the error is taken from the room, on the safe side
  const double room = 1 - error;
  const double up_m = reach.travel_m + reach.mean_travel_m;
  const double down_m = reach.travel_m - reach.mean_travel_m;
  const bool clear = !stops || (up_m < room * stops->gap_up_m && down_m < room * stops->gap_down_m);
  // contact holds while the preload exceeds what pulls
  const bool touches = !loss || -reach.skin_force_least_n < room * loss->preload_n;
  return scene.IsLinear() && clear && touches;
}

template <typename Steady>
// the peaks include the constant parts
Reach ReachOf(const Steady& steady) {
  return {.travel_m = steady.mover_peak_m - std::abs(steady.mean_travel_m),
          .mean_travel_m = steady.mean_travel_m,
          .skin_force_least_n = steady.skin_force_least_n};
}

}  // namespace

bool SteadyMotionIsFree(const EffectiveScene& scene, const SteadyState& steady) {
  return scene.scene.finger.tones.empty() && IsFree(scene, ReachOf(steady), steady.error_estimate);
}

bool SteadyMotionIsFree(const EffectiveScene& scene, const SteadyTones& steady) {
  return IsFree(scene, ReachOf(steady), steady.error_estimate);
}

}  // namespace haptometer::sim
