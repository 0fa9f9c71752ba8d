#include "sim/scene_run.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
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

// the last period's end is an output also where duration times rate is rounded up
TEST(SceneRun, OfWholeStepsHasNoOtherStep) {
  bool is_rounded = false;
  for (const double frequency_hz : {225.0, 190.0, 70.0, 53.0, 29.0}) {
    for (int periods = 1; periods <= 9; ++periods) {
      Scene scene = WithStops(1);
      scene.drive.frequency_hz = frequency_hz;
      const double duration_s = periods / frequency_hz;
      scene.duration_s = duration_s;
      const double rate_hz = OutputRateHz(scene);
      const double steps = std::round(periods * rate_hz / frequency_hz);
      is_rounded = is_rounded || duration_s * rate_hz > steps;
      const SceneRun run = RunScene(WithEffects(scene, Only({})), duration_s);
      EXPECT_EQ(static_cast<double>(run.skin_m.size()), steps + 1) << frequency_hz;
      EXPECT_EQ(run.begin_s, 0);
      EXPECT_EQ(run.skin_m(0), 0) << "at rest";
    }
  }
  EXPECT_TRUE(is_rounded) << "else any rounding up would do";
}

// ------------------------------------------------------------------------- errors of two runs

SceneRun SomeRun() {
  SceneRun run;
  run.skin_rms_m = 1e-4;
  run.case_rms_m = 2e-4;
  run.current_rms_a = 0.1;
  run.power_w = -0.3;
  run.mover_peak_m = 3e-4;
  run.mover_peak_of_run_m = 4e-4;
  run.temperature_rise_k = 5;
  run.temperature_peak_k = 6;
  run.skin_m = Eigen::VectorXd::LinSpaced(5, -1e-4, 0.5e-4);
  run.solver_tolerance = 1e-8;
  run.work.steps = 1000;
  return run;
}

// 1e-12, 4.4e-16 a step and 5e-4 of the tolerance, as the header states
constexpr double kRoundingOfSomeRun = 1e-12 + 1000 * 0x1p-51 + 5e-4 * 1e-8;

// of each number 1e-3: 64 / n of that, or what the coarser run states and that
TEST(ErrorOfRuns, IsThePartThatLessToleranceLeaves) {
  constexpr double kApart = 1e-3;
  const SceneRun run = SomeRun();
  for (double SceneRun::* number :
       {&SceneRun::skin_rms_m, &SceneRun::case_rms_m, &SceneRun::current_rms_a, &SceneRun::power_w,
        &SceneRun::mover_peak_m, &SceneRun::mover_peak_of_run_m, &SceneRun::temperature_rise_k,
        &SceneRun::temperature_peak_k}) {
    SceneRun coarse = run;
    coarse.*number *= 1 + kApart;
    coarse.error_estimate = 1;
    EXPECT_REL(ErrorOf(run, coarse, 2048), kApart / 32 + kRoundingOfSomeRun, 1e-9, "64 of 2048");
    coarse.error_estimate = 2e-6;
    EXPECT_REL(ErrorOf(run, coarse, 2048), kApart / 32 + kRoundingOfSomeRun, 1e-9, "64 of 2048");
    EXPECT_REL(ErrorOf(run, coarse, 64), kApart + kRoundingOfSomeRun, 1e-9, "all of it");
    EXPECT_REL(ErrorOf(run, coarse, 32), kApart + 2e-6 + kRoundingOfSomeRun, 1e-9, "the other's");
  }
}

// of the waveform over its peak, 1e-4 m
TEST(ErrorOfRuns, HoldsForTheWaveform) {
  const SceneRun run = SomeRun();
  SceneRun coarse = run;
  coarse.skin_m(3) -= 2e-7;
  coarse.error_estimate = 1;
  EXPECT_REL(Deviation(AskedQuantity::kSkinWaveform, coarse, run), 2e-3, 1e-9, "a difference");
  EXPECT_REL(ErrorOf(run, coarse, 2048), 2e-3 / 32 + kRoundingOfSomeRun, 1e-9, "64 of 2048");
  coarse.skin_m.conservativeResize(4);
  EXPECT_TRUE(std::isinf(Deviation(AskedQuantity::kSkinWaveform, coarse, run)));
}

TEST(ErrorOfRuns, OfEqualRunsIsTheirRounding) {
  const SceneRun run = SomeRun();
  EXPECT_REL(ErrorOf(run, run, 2), kRoundingOfSomeRun, 1e-9, "nothing else differs");
  SceneRun coarse = run;
  coarse.error_estimate = 3e-7;
  EXPECT_EQ(ErrorOf(run, coarse, 1), 3e-7) << "the same tolerance shows nothing";
  EXPECT_LT(ErrorOf(run, coarse, 1.01), 1e-11);
}

TEST(ErrorOfRuns, OfARunThatEndedEarlyIsUnknown) {
  const SceneRun run = SomeRun();
  SceneRun stalled = run, broken = run;
  stalled.stalled_at_s = 0.1;
  broken.power_w = std::numeric_limits<double>::quiet_NaN();
  for (const SceneRun& bad : {stalled, broken}) {
    EXPECT_TRUE(std::isinf(ErrorOf(run, bad, 2048)));
    EXPECT_TRUE(std::isinf(ErrorOf(bad, run, 2048)));
  }
}

TEST(ErrorOfRuns, IsFiniteWithAllNumbers) {
  EXPECT_TRUE(SomeRun().IsFinite());
  for (double SceneRun::* number :
       {&SceneRun::skin_rms_m, &SceneRun::case_rms_m, &SceneRun::current_rms_a, &SceneRun::power_w,
        &SceneRun::mover_peak_of_run_m, &SceneRun::temperature_rise_k}) {
    SceneRun run = SomeRun();
    run.*number = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(run.IsFinite());
  }
  SceneRun run = SomeRun();
  run.skin_m(2) = std::nan("");
  EXPECT_FALSE(run.IsFinite());
}

// each relative to the second run; the case and the power have no AskedQuantity
TEST(DeviationOfRuns, IsRelativeToTheReference) {
  const SceneRun reference = SomeRun();
  SceneRun run = reference;
  run.skin_rms_m = 1.5e-4;
  run.mover_peak_m = 1.5e-4;
  run.current_rms_a = 0.125;
  EXPECT_DOUBLE_EQ(Deviation(AskedQuantity::kSkinRms, run, reference), 0.5);
  EXPECT_DOUBLE_EQ(Deviation(AskedQuantity::kMoverPeak, run, reference), 0.5);
  EXPECT_DOUBLE_EQ(Deviation(AskedQuantity::kCurrentRms, run, reference), 0.25);
  EXPECT_EQ(Deviation(AskedQuantity::kSkinWaveform, run, reference), 0);
  EXPECT_DOUBLE_EQ(LargestDeviation(run, reference), 0.5);
  run = reference;
  run.power_w = 0.3;
  EXPECT_DOUBLE_EQ(LargestDeviation(run, reference), 2) << "of the other sign";
}

// a chirp's cubics, over its amplitude; other drives are exact
TEST(DriveErrors, AreRelativeToTheAmplitude) {
  Scene scene = tests::AdapterScene();
  EXPECT_EQ(DriveError(scene), 0);
  scene.drive = {.amplitude_v = 2,
                 .frequency_hz = 100,
                 .kind = DriveKind::kChirp,
                 .end_frequency_hz = 300,
                 .duration_s = 0.1234567,
                 .hold_tolerance = 1e-6};
  const double error = DriveError(scene);
  EXPECT_LE(error, 1e-6);
  EXPECT_GT(error, 0.9e-6) << "within one of some thousand cubics, to the fourth power";
  scene.drive.amplitude_v = -6;
  EXPECT_DOUBLE_EQ(DriveError(scene), error);
}

// Both bodies drift away at 1 m/s: what rounding leaves of their places is more of the travel
// between them, some 0.1 mm, than of each.
TEST(SceneRun, IsKnownAsLongAsItsTravelIs) {
  Scene scene = tests::ConeScene();
  scene.skin = {};
  scene.start = Start::kRest;
  scene.initial = {.mover_m_per_s = 1, .case_m_per_s = 1};
  const EffectiveScene effective = WithEffects(scene, Only({}));
  const SceneRun run = RunScene(effective, 0.02);
  // 4e-13 of it are the same for every run
  const double of_travel = run.error_estimate - 4e-13;
  ASSERT_GT(of_travel, 1e-13) << "more than any other number of the run is wrong by";
  scene.tolerance = of_travel / 2;
  EXPECT_TRUE(RunScene(WithEffects(scene, Only({})), 0.02).known_until_s);
}

// Ends of whole periods, counted back from the run's end, 129 at most: their integrals are the
// window's.
TEST(SceneRun, MarksTheEndsOfItsPeriods) {
  const Scene scene = WithStops(1);
  const EffectiveScene effective = WithEffects(scene, Only({}));
  for (const auto& [periods, marks] : {std::pair{12.0, 12U}, std::pair{12.25, 13U},
                                       std::pair{129.0, 129U}, std::pair{140.0, 129U}}) {
    const SceneRun run = RunScene(effective, periods / 225);
    ASSERT_EQ(run.marks.size(), marks) << periods;
    const PeriodMark& last = run.marks.back();
    EXPECT_EQ(last.positions(4), run.skin_m(run.skin_m.size() - 1)) << "the skin at the end";
    const double before = run.marks[marks - 11].skin_square_m2_s;
    EXPECT_REL(run.skin_rms_m, std::sqrt((last.skin_square_m2_s - before) / (10 / 225.0)), 1e-12,
               "differences of the same integrals");
  }
}

// of an exact run rounding and the chirp's cubics
TEST(SceneRun, OfAChirpHasItsCubicsInItsError) {
  Scene scene = WithStops(1);
  const double rounding = RunScene(WithEffects(scene, Only({})), 0.05).error_estimate;
  EXPECT_GE(rounding, 4e-13) << "of every number, as measured of peaks";
  EXPECT_LT(rounding, 1e-10) << "some hundred outputs of a linear motion";
  scene.drive = {.amplitude_v = 5,
                 .frequency_hz = 100,
                 .kind = DriveKind::kChirp,
                 .end_frequency_hz = 300,
                 .duration_s = 0.05,
                 .hold_tolerance = 1e-6};
  const SceneRun run = RunScene(WithEffects(scene, Only({})), 0.05);
  EXPECT_GE(run.error_estimate, DriveError(scene) + 4e-13);
  EXPECT_LT(run.error_estimate, DriveError(scene) + 1e-10);
}

// A coil in which nothing moves has its current without an error: what is left is 1e-14 of |v| |i|
// over the power, for the integrals, beside the 4e-13 of every number.
TEST(SceneRun, HasTheRoundingOfItsPowerInItsError) {
  Scene scene = WithStops(1);
  scene.actuator.inductance_h = 0;
  scene.actuator.force_constant_n_per_a = 0;
  scene.drive = {.amplitude_v = 3, .kind = DriveKind::kPulse, .hold_s = 1};
  const SceneRun run = RunScene(WithEffects(scene, Only({})), 0.05);
  const double R = scene.actuator.resistance_ohm;
  EXPECT_REL(run.power_w, 9 / R, 1e-13, "V^2 / R");
  EXPECT_REL(run.current_rms_a, 3 / R, 1e-13, "V / R");
  EXPECT_ABS(run.error_estimate, 4.1e-13, 1e-16, "rounding of the ratio");
}

// A coil of 1 H that nothing moves in takes 1e-5 of |v| |i| as power, whose error is as much
// larger; outputs of one phase in each period do not hide it.
TEST(SceneRun, OfSmallPowersTheErrorHoldsTheirs) {
  for (const double duration_s : {0.1, 0.1234567}) {
    Scene scene = tests::AdapterScene();
    scene.start = Start::kSteady;
    scene.actuator.force_constant_n_per_a = 0;
    scene.actuator.inductance_h = 1;
    scene.actuator.resistance_ohm = 1e-2;
    const SceneRun run = RunScene(WithEffects(scene, Only({Effect::kInductance})), duration_s);
    const double w = 2 * std::numbers::pi * 225;
    const double power_w = 12.5 * 1e-2 / (1e-4 + w * w);  // R V^2 / (2 |Z|^2)
    EXPECT_LE(std::abs(run.power_w / power_w - 1), run.error_estimate) << duration_s;
    EXPECT_LT(run.error_estimate, 1e-5);
  }
}

}  // namespace
}  // namespace haptometer::sim
