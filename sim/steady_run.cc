#include "sim/steady_run.h"

#include <fmt/core.h>

#include <cmath>
#include <utility>

#include "sim/period_map.h"
#include "sim/piecewise_scene.h"
#include "sim/smooth_scene.h"
#include "sim/solver_ladder.h"
#include "sim/steady_state.h"
#include "sim/superposition.h"

namespace haptometer::sim {

namespace {

// as often as motions of period 1, 2 and 4 have in common
constexpr double kPlayedPeriods = 8;
// before a search with less tolerance, from what the one before found
constexpr int kShortTransient = 4;

double PlayedS(const EffectiveScene& scene) {
  return kPlayedPeriods / scene.scene.drive.frequency_hz;
}

// the linear steady motion may lie beyond a stop
PiecewiseStart AtRest(const EffectiveScene& scene) {
  EffectiveScene resting = scene;
  resting.scene.start = Start::kRest;
  return StartIn(resting);
}

std::string NoneFound(const PeriodicSearch& search) {
  return fmt::format("no stable motion was found that repeats itself every 1, 2 or 4 periods ({})",
                     search.tried);
}

SteadyRun PlayLinear(const EffectiveScene& scene) {
  SteadyRun steady;
  EffectiveScene linear = scene;
  linear.piecewise = {};
  linear.scene.start = Start::kSteady;
  steady.start = PiecewiseStartOf(linear.scene);
  steady.run = RunScene(linear, PlayedS(scene), steady.start);
  return steady;
}

SteadyRun PlaySuperposed(const EffectiveScene& scene) {
  SteadyRun steady;
  const Superposition motion = Superpose(scene.scene);
  if (!(motion.error_estimate < 1)) {
    steady.tried = "the tremor meets an undamped resonance";
    return steady;
  }
  if (!SteadyMotionIsFree(scene, motion)) {
    steady.tried =
        "tremor and drive have no common period in which a limited motion repeats itself";
    return steady;
  }
  EffectiveScene linear = scene;
  linear.piecewise = {};
  steady.start.x = motion.state;
  SceneRun run = RunScene(linear, PlayedS(scene), steady.start);
  run.skin_rms_m = motion.skin_rms_m;
  run.case_rms_m = motion.case_rms_m;
  run.current_rms_a = motion.current_rms_a;
  run.power_w = motion.power_w;
  run.mover_peak_m = run.mover_peak_of_run_m = motion.mover_peak_m;
  steady.run = std::move(run);
  return steady;
}

SteadyRun PlayLimited(const EffectiveScene& scene) {
  SteadyRun steady;
  const PeriodMap map(AssemblePiecewise(scene.scene, scene.piecewise), scene.scene.drive);
  const PiecewiseStart start = AtRest(scene);
  PeriodicSearch search = FindPeriodicMotion(map, map.PointOf(start.mode, start.x));
  steady.tried = NoneFound(search);
  if (!search.found || !search.found->stable) return steady;
  steady.start = map.StartOf(search.found->point);
  steady.run = RunScene(scene, PlayedS(scene), steady.start);
  steady.periodic = std::move(search.found);
  return steady;
}

// The motion that a smooth scene settles to, at one tolerance after the other.
class SmoothSearch {
 public:
  explicit SmoothSearch(const EffectiveScene& scene)
      : scene_(scene), system_(AssembleSmooth(scene.scene, scene.piecewise, scene.smooth)) {}

  SteadyRun Find() {
    SolverLadder ladder(scene_.scene.tolerance);
    const PiecewiseStart rest = AtRest(scene_);
    const PeriodMap map = MapOf(ladder.before());
    SteadyRun coarse = Settle(map, map.PointOf(rest.mode, rest.x), {}, ladder.before());
    OdeWork work = coarse.run ? coarse.run->work : OdeWork{};
    for (; coarse.run; ladder.Refine()) {
      SteadyRun fine = Settle(MapOf(ladder.tolerance()), coarse.periodic->point,
                              {.transient_periods = kShortTransient}, ladder.tolerance());
      if (!fine.run) return fine;
      work += fine.run->work;
      fine.run->work = work;
      fine.run->error_estimate = ErrorOf(*fine.run, *coarse.run, ladder.finer());
      if (ladder.EndsWith(fine.run->error_estimate)) return fine;
      coarse = std::move(fine);
    }
    return coarse;
  }

 private:
  PeriodMap MapOf(double tolerance) const {
    return {system_, scene_.scene.drive, SmoothSettings{.tolerance = tolerance}};
  }

  SteadyRun Settle(const PeriodMap& map, const PeriodPoint& from, const PeriodicSettings& settings,
                   double tolerance) const {
    SteadyRun steady;
    PeriodicSearch search = FindPeriodicMotion(map, from, settings);
    steady.tried = NoneFound(search);
    if (!search.found || !search.found->stable) return steady;
    const PeriodPoint& point = search.found->point;
    steady.start = map.StartOf(point);
    if (scene_.smooth.heating) steady.temperature_rise_k = point.x(point.x.size() - 1);
    steady.run =
        RunSmoothly(scene_, PlayedS(scene_), steady.start, steady.temperature_rise_k, tolerance);
    steady.periodic = std::move(search.found);
    return steady;
  }

  const EffectiveScene& scene_;
  SmoothSystem system_;
};

SteadyRun PlaySmooth(const EffectiveScene& scene) {
  SteadyRun steady;
  if (!scene.scene.finger.tones.empty()) {
    steady.tried = "tremor and drive have no common period in which a bent motion repeats itself";
    return steady;
  }
  if (scene.smooth.heating && std::isinf(scene.smooth.heating->thermal_resistance_k_per_w)) {
    steady.tried = "no heat leaves the coil: [coil_heating] has no thermal_resistance_k_per_w";
    return steady;
  }
  return SmoothSearch(scene).Find();
}

}  // namespace

SteadyRun PlaySteady(const EffectiveScene& scene) {
  if (!scene.IsLinear()) return PlaySmooth(scene);
  if (!scene.scene.finger.tones.empty()) return PlaySuperposed(scene);
  if (SteadyMotionIsFree(scene, SolveSteadyState(scene.scene))) return PlayLinear(scene);
  return PlayLimited(scene);
}

}  // namespace haptometer::sim
