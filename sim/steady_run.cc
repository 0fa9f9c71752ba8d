#include "sim/steady_run.h"

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
    steady.run = RunScene(linear, PlayedS(scene));
    return steady;
  }
  const PeriodMap map(AssemblePiecewise(scene.scene, scene.piecewise), scene.scene.drive);
  const PiecewiseStart start = PiecewiseStartOf(scene.scene);
  PeriodicSearch search = FindPeriodicMotion(map, map.PointOf(start.mode, start.x));
  steady.tried = search.tried;
  if (!search.found || !search.found->stable) return steady;
  steady.run = RunScene(scene, PlayedS(scene), map.StartOf(search.found->point));
  steady.periodic = std::move(search.found);
  return steady;
}

}  // namespace haptometer::sim
