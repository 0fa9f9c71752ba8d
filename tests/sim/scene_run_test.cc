#include "sim/scene_run.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string_view>

#include "sim/effect_choice.h"
#include "sim/linear_model.h"
#include "sim/sensor_model.h"
#include "sim/steady_run.h"
#include "sim/steady_state.h"
#include "sim/time_response.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

EffectSet Only(std::initializer_list<Effect> effects) {
  EffectSet on;
  on.set(PlaceOf(Effect::kInductance));
  for (const Effect effect : effects) on.set(PlaceOf(effect));
  return on;
}

Scene WithStops(double gap_m) {
  Scene scene = tests::AdapterScene();
  scene.start = Start::kRest;
  scene.effects.travel_stops =
      TravelStops{.gap_up_m = gap_m, .gap_down_m = gap_m, .restitution = 0.5};
  scene.effects.contact_loss = ContactLoss{0.07};
  return scene;
}

TEST(SceneRun, OfALinearSceneIsItsTimeResponse) {
  const Scene scene = WithStops(1);
  const LinearModel model = AssembleModel(scene);
  const TimeResponse response(model, scene.drive, Start::kRest);
  // whole steps of the outputs, an odd one first, less than ten periods
  for (const double duration_s : {0.1, 0.1234567, 0.02}) {
    const SceneRun run = RunScene(WithEffects(scene, Only({Effect::kTravelStops})), duration_s);
    EXPECT_ABS(run.begin_s, std::max(0.0, duration_s - 10 / 225.0), 1e-16, "rounding");
    EXPECT_REL(run.skin_rms_m, response.WindowRms(model.skin(), run.begin_s, duration_s), 1e-11,
               "differences of integrals since t = 0");
    EXPECT_REL(run.case_rms_m, response.WindowRms(LinearModel::kCase, run.begin_s, duration_s),
               1e-11, "differences of integrals since t = 0");
    EXPECT_TRUE(run.events.empty());
    const Eigen::VectorXd last = response.StateAt(duration_s);
    EXPECT_REL(run.skin_m(run.skin_m.size() - 1), last(model.skin()), 1e-10, "of less than a peak");
    EXPECT_ABS(run.ledger.Imbalance(), 0, 1e-12, "exact integrals");
  }
}

TEST(SceneRun, OfASteadySceneShowsThePhasors) {
  Scene scene = WithStops(1);
  scene.start = Start::kSteady;
  const SteadyState steady = SolveSteadyState(scene);
  const SceneRun run = RunScene(WithEffects(scene, Only({})), 0.1);
  EXPECT_REL(run.skin_rms_m, steady.skin_rms_m, 1e-12, "ten whole periods");
  EXPECT_REL(run.current_rms_a, steady.current_rms_a, 1e-12, "ten whole periods");
  EXPECT_REL(run.power_w, steady.power_w, 1e-12, "ten whole periods");
  EXPECT_REL(run.mover_peak_m, steady.mover_peak_m, 1e-10, "a quintic over 1/64 period");
}

TEST(SceneRun, CountsItsEventsAndStopsAtTheGap) {
  const SceneRun run = RunScene(
      WithEffects(WithStops(0.3e-3), Only({Effect::kTravelStops, Effect::kContactLoss})), 0.1);
  EXPECT_EQ(run.mover_peak_of_run_m, 0.3e-3);
  EXPECT_ABS(run.ledger.Imbalance(), 0, 1e-12, "exact integrals");
  std::size_t impacts = 0;
  for (const EventCount& event : run.events) {
    if (event.name.starts_with("impact")) impacts += event.count;
  }
  EXPECT_GT(impacts, 10U);
}

TEST(SceneRun, GravityMovesWhatLimitsTheMotion) {
  Scene scene = WithStops(0.3e-3);
  const EffectiveScene with =
      WithEffects(scene, Only({Effect::kGravity, Effect::kTravelStops, Effect::kContactLoss}));
  const double sag_m = 1.4e-3 * 9.80665 / 2800;
  EXPECT_REL(with.piecewise.stops->gap_up_m, 0.3e-3 - sag_m, 1e-15, "rounding");
  EXPECT_REL(with.piecewise.stops->gap_down_m, 0.3e-3 + sag_m, 1e-15, "rounding");
  EXPECT_REL(with.piecewise.contact_loss->preload_n, 0.07 + 9.80665 * (2e-3 + 4.6e-3), 1e-15,
             "rounding");
  // alone it changes nothing
  EXPECT_EQ(RunScene(WithEffects(scene, Only({Effect::kGravity})), 0.05).skin_m,
            RunScene(WithEffects(scene, Only({})), 0.05).skin_m);
}

// "as if the drive had been on forever" never lies beyond a stop
TEST(PlayedMotion, OfASteadyStartIsTheMotionThatSettles) {
  Scene scene = WithStops(0.4e-3);
  scene.start = Start::kSteady;
  scene.effects[Effect::kTravelStops] = Wish::kOn;
  const EffectSet on = Only({Effect::kTravelStops});
  const SteadyRun settled = PlaySteady(WithEffects(scene, on));
  ASSERT_TRUE(settled.run);
  const trial::Displacement motion = MotionOf(scene, SensorTarget::kSkin);
  const double peak_m = settled.run->skin_m.cwiseAbs().maxCoeff();
  for (const Eigen::Index k : {0, 100, 500}) {
    EXPECT_ABS(motion(static_cast<double>(k) / settled.run->outputs_rate_hz),
               settled.run->skin_m(k), 1e-9 * peak_m, "an ulp of t apart, or a quintic");
  }
  scene.duration_s = 0.02;
  const PlayedScene played = PlayWith(scene, on);
  ASSERT_TRUE(played.answered);
  EXPECT_LE(played.run.mover_peak_of_run_m, 0.4e-3 * (1 + 1e-12));
}

// a sensor over a scene with stops sees the motion that the run has, in any order of asking
TEST(PlayedMotion, IsTheRunsMotion) {
  Scene scene = WithStops(0.3e-3);
  scene.effects[Effect::kTravelStops] = Wish::kOn;
  const SceneRun run = RunScene(WithEffects(scene, Only({Effect::kTravelStops})), 0.1);
  const trial::Displacement motion = MotionOf(scene, SensorTarget::kSkin);
  const double peak_m = run.skin_m.cwiseAbs().maxCoeff();
  for (const Eigen::Index k : {500, 3, 640, 0, 639}) {
    const double t_s = run.begin_s + static_cast<double>(k) / run.outputs_rate_hz;
    EXPECT_ABS(motion(t_s), run.skin_m(k), 1e-9 * peak_m, "an ulp of t apart, or a quintic");
  }
  EXPECT_EQ(motion(-1), 0);
  // linear while nothing is reached
  scene.effects.travel_stops->gap_up_m = scene.effects.travel_stops->gap_down_m = 1;
  const trial::Displacement far = MotionOf(scene, SensorTarget::kMover);
  scene.effects = {};
  const trial::Displacement linear = MotionOf(scene, SensorTarget::kMover);
  for (const double t_s : {0.0123456, 0.05, 0.0999}) {
    EXPECT_ABS(far(t_s), linear(t_s), 1e-13, "a quintic over 1/64 period of 0.5 mm");
  }
}

}  // namespace
}  // namespace haptometer::sim
