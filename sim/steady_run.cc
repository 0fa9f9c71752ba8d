#include "sim/steady_run.h"

#include <fmt/core.h>

#include "sim/period_map.h"
#include "sim/piecewise_scene.h"
#include "sim/steady_state.h"

namespace haptometer::sim {

namespace {

// as often as motions of period 1, 2 and 4 have in common
constexpr double kPlayedPeriods = 8;

double PlayedS(const EffectiveScene& scene) {
  return kPlayedPeriods / scene.scene.drive.frequency_hz;
}

}  // namespace

SteadyRun PlaySteady(const EffectiveScene& scene) {
  SteadyRun steady;
  if (SteadyMotionIsFree(scene, SolveSteadyState(scene.scene))) {
    EffectiveScene linear{.scene = scene.scene, .piecewise = {}};
    linear.scene.start = Start::kSteady;
    steady.start = PiecewiseStartOf(linear.scene);
    steady.run = RunScene(linear, PlayedS(scene), steady.start);
    return steady;
  }
  const PeriodMap map(AssemblePiecewise(scene.scene, scene.piecewise), scene.scene.drive);
  // the linear steady motion may lie beyond a stop
  Scene resting = scene.scene;
  resting.start = Start::kRest;
  const PiecewiseStart start = PiecewiseStartOf(resting);
  PeriodicSearch search = FindPeriodicMotion(map, map.PointOf(start.mode, start.x));
  steady.tried = fmt::format(
      "no stable motion was found that repeats itself every 1, 2 or 4 periods ({})", search.tried);
  if (!search.found || !search.found->stable) return steady;
  steady.start = map.StartOf(search.found->point);
  steady.run = RunScene(scene, PlayedS(scene), steady.start);
  steady.periodic = std::move(search.found);
  return steady;
}

}  // namespace haptometer::sim
