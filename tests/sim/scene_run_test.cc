#include "sim/scene_run.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/effect_choice.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/steady_state.h"
#include "sim/linear/time_response.h"
#include "sim/scene/scene_file.h"
#include "sim/sensor_model.h"
#include "sim/steady_run.h"
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
  EXPECT_REL(run.mover_peak_of_run_m, 0.3e-3, 1e-14, "rounding of the place of an impact");
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

// ---------------------------------------------------------------- smooth effects and the finger

Scene Heated(double resistance_per_k) {
  Scene scene = WithStops(0.3e-3);
  scene.effects.coil_heating =
      CoilHeating{.heat_capacity_j_per_k = 1e-3,
                  .thermal_resistance_k_per_w = std::numeric_limits<double>::infinity(),
                  .resistance_per_k = resistance_per_k};
  return scene;
}

// what only warms changes nothing: the solver against the exact motion, free and between stops
TEST(SceneRun, HeatThatChangesNothingLeavesTheExactRun) {
  Scene scene = Heated(0);
  for (const double tolerance : {1e-4, 1e-8, 1e-10}) {
    scene.tolerance = tolerance;
    for (const Effect limit : {Effect::kGravity, Effect::kTravelStops}) {
      const SceneRun exact = RunScene(WithEffects(scene, Only({limit})), 0.05);
      const SceneRun run = RunScene(WithEffects(scene, Only({limit, Effect::kCoilHeating})), 0.05);
      for (std::size_t k = 0; k < kAskedQuantityNames.size(); ++k) {
        const double apart = Deviation(static_cast<AskedQuantity>(k), run, exact);
        EXPECT_LE(apart, tolerance) << kAskedQuantityNames[k];
        EXPECT_LE(apart, run.error_estimate) << kAskedQuantityNames[k];
      }
      EXPECT_LE(run.error_estimate, tolerance / 4);
      EXPECT_LT(exact.error_estimate, 1e-11) << "rounding, and what a few events make of it";
      EXPECT_EQ(exact.solver_tolerance, 0);
      EXPECT_GT(run.solver_tolerance, 0);
      EXPECT_REL(run.power_w, exact.power_w, 10 * tolerance, "an integral like the others");
      // no heat leaves
      EXPECT_REL(1e-3 * run.temperature_rise_k, run.ledger.dissipated_j[0], 10 * tolerance,
                 "the tolerance");
      EXPECT_EQ(run.temperature_peak_k, run.temperature_rise_k);
      EXPECT_GT(run.work.steps, 0);
    }
  }
}

// a spring that is weak bends the motion in proportion: Richardson's limit is the linear one
TEST(SceneRun, AWeakSpringBendsInProportion) {
  Scene scene = WithStops(1);
  scene.tolerance = 1e-9;
  const auto rms_m = [&](double cubic) {
    scene.effects.stiffening = StiffeningSpring{.cubic_n_per_m3 = cubic};
    return RunScene(WithEffects(scene, Only({Effect::kStiffening})), 0.05).skin_rms_m;
  };
  const double linear_m = RunScene(WithEffects(scene, Only({})), 0.05).skin_rms_m;
  const double one = rms_m(1e5) - linear_m, two = rms_m(2e5) - linear_m;
  EXPECT_GT(std::abs(one), 1e-6 * linear_m);
  EXPECT_REL(two, 2 * one, 1e-3, "the second order is 1.3e-4 of the first");
}

// a weak spring under a file's voltages: neither steps nor tolerance limit what a run leaves out,
// but the iteration within each step
TEST(SceneRun, OfAFilesVoltagesTheStatedErrorHolds) {
  Scene scene = tests::AdapterScene();
  scene.start = Start::kRest;
  scene.actuator = {.moving_mass_kg = 1.05e-3,
                    .case_mass_kg = 0.717e-3,
                    .stiffness_n_per_m = 1431,
                    .damping_n_s_per_m = 0.0515,
                    .force_constant_n_per_a = 0.512,
                    .resistance_ohm = 24,
                    .inductance_h = 0.843e-3};
  scene.adapter = Adapter{.motor_side_mass_kg = 0.357e-3,
                          .skin_side_mass_kg = 2.24e-3,
                          .stiffness_n_per_m = 5057,
                          .damping_n_s_per_m = 0.1735};
  scene.skin.stiffness_n_per_m = 834;
  scene.skin.damping_n_s_per_m = 2.217;
  scene.effects.stiffening = StiffeningSpring{.cubic_n_per_m3 = 4.08e9};
  VoltageSamples samples{.rate_hz = 1967.23, .voltages_v = {}};
  for (int k = 0; k < 117; ++k) samples.voltages_v.push_back(0.6 * std::sin(1.319 * k * k));
  scene.drive = {.kind = DriveKind::kSamples,
                 .samples = std::make_shared<const VoltageSamples>(samples)};
  scene.tolerance = 1e-11;
  const SceneRun exact = RunScene(WithEffects(scene, Only({Effect::kStiffening})), 0.065);
  for (const double tolerance : {1e-2, 1e-6}) {
    scene.tolerance = tolerance;
    const SceneRun run = RunScene(WithEffects(scene, Only({Effect::kStiffening})), 0.065);
    EXPECT_LE(LargestDeviation(run, exact), run.error_estimate) << tolerance;
    EXPECT_LE(run.error_estimate, tolerance);
  }
}

// the coil's temperatures are numbers of the run as the others are
TEST(SceneRun, TheStatedErrorHoldsForTemperatures) {
  Scene scene = tests::AdapterScene();
  scene.adapter.reset();
  scene.start = Start::kRest;
  scene.drive = {.amplitude_v = 5, .kind = DriveKind::kPulse, .hold_s = 5e-3};
  scene.effects.coil_heating =
      CoilHeating{.heat_capacity_j_per_k = 0.01, .thermal_resistance_k_per_w = 10};
  scene.tolerance = 1e-11;
  const EffectiveScene heating = WithEffects(scene, Only({Effect::kCoilHeating}));
  const SceneRun exact = RunScene(heating, 0.05);
  for (const double tolerance : {1e-2, 1e-4, 1e-6}) {
    scene.tolerance = tolerance;
    const SceneRun run = RunScene(WithEffects(scene, Only({Effect::kCoilHeating})), 0.05);
    EXPECT_REL(run.temperature_rise_k, exact.temperature_rise_k, run.error_estimate, "stated");
    EXPECT_REL(run.temperature_peak_k, exact.temperature_peak_k, run.error_estimate, "stated");
  }
}

TEST(SceneRun, GravityStretchesTheStiffeningSpring) {
  Scene scene = WithStops(0.3e-3);
  scene.effects.stiffening = StiffeningSpring{.cubic_n_per_m3 = 1e15};
  const EffectiveScene with =
      WithEffects(scene, Only({Effect::kGravity, Effect::kStiffening, Effect::kTravelStops}));
  const double sag_m = with.smooth.spring->sag_m, weight_n = 1.4e-3 * 9.80665;
  EXPECT_REL(2800 * sag_m + 1e15 * std::pow(sag_m, 3), weight_n, 1e-14, "Kv s + K3 s^3 = Mv g");
  EXPECT_EQ(with.piecewise.stops->gap_up_m, 0.3e-3 - sag_m);
  EXPECT_EQ(WithEffects(scene, Only({Effect::kStiffening})).smooth.spring->sag_m, 0);
}

Scene Trembling(std::vector<Tone> tones) {
  Scene scene = WithStops(1);
  scene.finger.tones = std::move(tones);
  scene.duration_s.reset();
  scene.start.reset();
  return scene;
}

// ten periods of the drive are one of the tremor: what is superposed is what a run integrates
TEST(SteadyRun, SuperposesTremor) {
  const std::vector<std::vector<Tone>> cases{
      {{.amplitude = 50e-6, .frequency_hz = 22.5, .phase_rad = 1}},
      {{.amplitude = 50e-6, .frequency_hz = 225, .phase_rad = 2}},  // in step with the drive
      {{.amplitude = 20e-6, .frequency_hz = 45}, {.amplitude = 9e-6, .frequency_hz = 67.5}}};
  for (const std::vector<Tone>& tones : cases) {
    const EffectiveScene scene = WithEffects(Trembling(tones), Only({Effect::kTremor}));
    const SteadyRun steady = PlaySteady(scene);
    ASSERT_TRUE(steady.run);
    const SceneRun run = RunScene(scene, 10 / 225.0, steady.start);
    EXPECT_REL(run.skin_rms_m, steady.run->skin_rms_m, 1e-11, "a whole period");
    EXPECT_REL(run.case_rms_m, steady.run->case_rms_m, 1e-11, "a whole period");
    EXPECT_REL(run.current_rms_a, steady.run->current_rms_a, 1e-11, "a whole period");
    EXPECT_REL(run.power_w, steady.run->power_w, 1e-10, "a whole period");
    EXPECT_LE(run.mover_peak_m, steady.run->mover_peak_m * (1 + 1e-9));
  }
}

TEST(SteadyRun, RefusesWhatTremorNeverLetsRepeat) {
  Scene scene = Trembling({{.amplitude = 50e-6, .frequency_hz = 9}});
  scene.effects.travel_stops->gap_up_m = 0.3e-3;
  const SteadyRun limited =
      PlaySteady(WithEffects(scene, Only({Effect::kTremor, Effect::kTravelStops})));
  EXPECT_FALSE(limited.run);
  ASSERT_TRUE(limited.refusal);
  EXPECT_EQ(limited.refusal->kind, FindingKind::kTremorWithLimits);
  scene.effects.stiffening = StiffeningSpring{.cubic_n_per_m3 = 1e9};
  EXPECT_FALSE(PlaySteady(WithEffects(scene, Only({Effect::kTremor, Effect::kStiffening}))).run);
  EXPECT_FALSE(PlaySteady(WithEffects(Heated(0.01), Only({Effect::kCoilHeating}))).run)
      << "no heat leaves";
}

// alpha = 0: the mean of R i^2 over the resistance of the way out, a ripple apart
TEST(SteadyRun, SettlesAtTheTemperatureThatItsPowerHolds) {
  Scene scene = Heated(0);
  scene.tolerance = 1e-7;
  scene.effects.coil_heating->thermal_resistance_k_per_w = 100;
  scene.effects.coil_heating->heat_capacity_j_per_k = 10;  // a quarter of an hour
  const SteadyRun steady = PlaySteady(WithEffects(scene, Only({Effect::kCoilHeating})));
  ASSERT_TRUE(steady.run);
  const SteadyState linear = SolveSteadyState(scene);
  EXPECT_REL(steady.run->skin_rms_m, linear.skin_rms_m, 1e-7, "the tolerance");
  EXPECT_REL(steady.run->current_rms_a, linear.current_rms_a, 1e-7, "the tolerance");
  EXPECT_LE(steady.run->error_estimate, scene.tolerance);
  const double rise_k = 100 * scene.actuator.resistance_ohm * std::pow(linear.current_rms_a, 2);
  EXPECT_REL(steady.run->temperature_rise_k, rise_k, 1e-3, "a period's error times 2e5");
}

// what counts as the same state again may not be as loose as the answer: a search with differences
// of 1e-4 found nothing here
TEST(SteadyRun, OfALooseToleranceIsTheMotionOfATightOne) {
  const auto read = ReadSceneText(R"(
[actuator]
moving_mass_kg = 0.95e-3
case_mass_kg = 0.623e-3
damping_n_s_per_m = 0.0179
force_constant_n_per_a = 0.835
resistance_ohm = 26
inductance_h = 0
stiffness_n_per_m = 666.4
[adapter]
motor_side_mass_kg = 0.133e-3
skin_side_mass_kg = 4.305e-3
stiffness_n_per_m = 5240
damping_n_s_per_m = 0.2014
[skin]
stiffness_n_per_m = 703.2
damping_n_s_per_m = 0.7642
[drive]
kind = "sine"
amplitude_v = 4.315
frequency_hz = 192.6
[stiffening]
cubic_n_per_m3 = 16.75e9
)",
                                  "scene.toml");
  ASSERT_TRUE(read.has_value()) << read.error().Text();
  Scene scene = *read;
  scene.tolerance = 1e-6;
  const SteadyRun tight = PlaySteady(WithEffects(scene, Only({Effect::kStiffening})));
  ASSERT_TRUE(tight.periodic);
  for (const double tolerance : {1e-4, 1e-3, 1e-2}) {
    scene.tolerance = tolerance;
    const SteadyRun loose = PlaySteady(WithEffects(scene, Only({Effect::kStiffening})));
    ASSERT_TRUE(loose.periodic) << tolerance;
    EXPECT_EQ(loose.periodic->drive_periods, tight.periodic->drive_periods);
    EXPECT_LE(loose.run->error_estimate, tolerance);
    EXPECT_REL(loose.run->skin_rms_m, tight.run->skin_rms_m, loose.run->error_estimate + 1e-6,
               "what both state");
  }
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
