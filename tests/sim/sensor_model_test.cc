#include "sim/sensor_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim/linear/linear_model.h"
#include "sim/linear/steady_state.h"
#include "sim/linear/time_response.h"
#include "sim/waveforms.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

Scene SensedScene() {
  Scene scene = tests::AdapterScene();
  scene.sensor = IdealSensor();
  return scene;
}

// root mean square of a record's values, no window
double Rms(const trial::Record& record) {
  double sum = 0;
  for (const double value : record.channels[0].values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(record.rows));
}

TEST(Motion, InSteadyStateIsTheTimeResponse) {
  const Scene scene = tests::AdapterScene();
  const LinearModel model = AssembleModel(scene);
  const TimeResponse response(model, scene.drive, Start::kSteady);
  for (const SensorTarget target :
       {SensorTarget::kSkin, SensorTarget::kCase, SensorTarget::kMover}) {
    const trial::Displacement motion = MotionOf(scene, target);
    for (const double t_s : {0.0, 1e-3, 0.7, 123.456}) {
      EXPECT_ABS(motion(t_s), response.StateAt(t_s)(StateOf(model, target)), 2e-16,
                 "2e-13 of the amplitude");
    }
  }
}

TEST(Motion, FromRestIsTheTimeResponseAndZeroBefore) {
  Scene scene = tests::AdapterScene();
  scene.start = Start::kRest;
  const TimeResponse response(AssembleModel(scene), scene.drive, Start::kRest);
  const trial::Displacement motion = MotionOf(scene, SensorTarget::kSkin);
  EXPECT_EQ(motion(-1), 0);
  EXPECT_EQ(motion(0), 0);
  EXPECT_EQ(motion(0.0123), response.StateAt(0.0123)(4));
}

TEST(Motion, OfALateSensorIsOlder) {
  Scene scene = SensedScene();
  scene.sensor->latency_s = 4e-3;
  scene.sensor->target = SensorTarget::kMover;
  const trial::Displacement motion = MotionOf(scene, SensorTarget::kMover);
  EXPECT_EQ(SensedMotion(scene)(0.05), motion(0.05 - 4e-3));
}

TEST(SimulatedRecord, OfAnIdealSensorIsTheMotion) {
  const Scene scene = SensedScene();
  const trial::Record record = SimulateRecord(scene, 0.4);
  ASSERT_EQ(record.rows, 4000U);
  ASSERT_EQ(record.channels.size(), 1U);
  const trial::Channel& channel = record.channels[0];
  EXPECT_EQ(channel.role, trial::ChannelRole::kDisplacement);
  EXPECT_EQ(channel.unit, "m");
  EXPECT_EQ(channel.statuses[17], trial::SampleStatus::kOk);
  const trial::Displacement motion = MotionOf(scene, SensorTarget::kSkin);
  for (const std::size_t row : {0U, 1U, 17U, 3999U}) {
    EXPECT_ABS(channel.values[row], motion(trial::TimeOf(record, row)), 1e-17,
               "time as k T or k / rate: one rounding");
  }
  // 90 whole periods in 4000 samples
  EXPECT_REL(Rms(record), SolveSteadyState(scene).skin_rms_m, 3e-15, "an integer of periods");
}

TEST(SimulatedRecord, SaysWhatItIs) {
  Scene scene = SensedScene();
  scene.sensor->target = SensorTarget::kCase;
  const trial::Record record = SimulateRecord(scene, 0.1);
  EXPECT_EQ(record.metadata.source,
            "simulated: linear scene, exact solution, start from steady state");
  EXPECT_EQ(record.metadata.laser_spot, "case");
  EXPECT_EQ(record.metadata.head, "ideal");
  EXPECT_EQ(record.metadata.drive_frequency_hz, 225);
  EXPECT_EQ(record.metadata.drive_amplitude_v, 5);
  EXPECT_EQ(record.metadata.nominal_rate_hz, 1e4);
  ASSERT_EQ(record.stretches.size(), 1U);
  EXPECT_EQ(record.stretches[0].rate_hz, 1e4);
  EXPECT_EQ(record.stretches[0].rows, record.rows);
  scene.duration_s = 0.1;
  EXPECT_EQ(SimulateRecord(scene, 0.1).metadata.source,
            "simulated: linear scene, exact solution, start from rest");
}

// An average of N samples turns the amplitude down by the Dirichlet kernel.
TEST(SimulatedRecord, OfAnAveragingHeadIsTurnedDownByItsKernel) {
  Scene scene = SensedScene();
  scene.sensor->head.averages = 16;
  const double x = std::numbers::pi * 225 * 1e-4;
  const double gain = std::sin(16 * x) / (16 * std::sin(x));
  EXPECT_REL(Rms(SimulateRecord(scene, 0.4)), gain * SolveSteadyState(scene).skin_rms_m, 3e-15,
             "closed form");
}

// A slower reading shows every nth raw sample.
TEST(SimulatedRecord, AtAFractionOfTheSamplingTakesEveryNth) {
  Scene scene = SensedScene();
  scene.sensor->head.noise_rms_m = 1e-6;
  const trial::Record all = SimulateRecord(scene, 0.1);
  scene.sensor->rate_hz = 2500;
  const trial::Record some = SimulateRecord(scene, 0.1);
  ASSERT_EQ(some.rows, 250U);
  for (std::size_t row = 0; row < some.rows; ++row) {
    EXPECT_EQ(some.channels[0].values[row], all.channels[0].values[4 * row]);
  }
}

TEST(SimulatedRecord, WithNoiseIsTheSameForTheSameSeed) {
  Scene scene = SensedScene();
  scene.sensor->head.noise_rms_m = 1e-6;
  const trial::Record first = SimulateRecord(scene, 0.05);
  EXPECT_EQ(SimulateRecord(scene, 0.05).channels[0].values, first.channels[0].values);
  scene.sensor->seed = 2;
  EXPECT_NE(SimulateRecord(scene, 0.05).channels[0].values, first.channels[0].values);
}

TEST(SimulatedRecord, BeyondTheRangeHasNoValue) {
  Scene scene = SensedScene();
  scene.sensor->head.range_max_m = 100e-6;
  scene.sensor->head.range_min_m = -100e-6;
  const trial::Record record = SimulateRecord(scene, 0.01);
  std::size_t over = 0, under = 0;
  for (std::size_t row = 0; row < record.rows; ++row) {
    const trial::SampleStatus status = record.channels[0].statuses[row];
    over += status == trial::SampleStatus::kOver ? 1 : 0;
    under += status == trial::SampleStatus::kUnder ? 1 : 0;
    EXPECT_EQ(std::isnan(record.channels[0].values[row]), !trial::IsMeasurement(status));
  }
  EXPECT_GT(over, 20U);
  EXPECT_GT(under, 20U);
}

// whole readings also where duration times rate is rounded
TEST(SimulatedRecord, HasTheReadingsOfItsDuration) {
  Scene scene = SensedScene();
  for (const double rate_hz : {1e4, 2500.0, 312.5}) {
    scene.sensor->rate_hz = rate_hz;
    EXPECT_EQ(SamplesPerReading(*scene.sensor), std::llround(1e4 / rate_hz));
    for (std::size_t rows = 1; rows <= 40; ++rows) {
      const double duration_s = static_cast<double>(rows) / rate_hz;
      EXPECT_EQ(SimulateRecord(scene, duration_s).rows, rows) << rate_hz;
      EXPECT_EQ(SimulateRecord(scene, duration_s + 0.999 / rate_hz).rows, rows) << rate_hz;
    }
  }
}

// with an offset the motion is played, and its mean is that of the statics: none at the skin, and
// the coil's force over Kv between mover and case
TEST(Motion, UnderAnOffsetHasItsMean) {
  Scene scene = tests::AdapterScene();
  const trial::Displacement plain = MotionOf(scene, SensorTarget::kMover);
  const trial::Displacement skin = MotionOf(scene, SensorTarget::kSkin);
  scene.drive.offset_v = 2;
  const trial::Displacement pushed = MotionOf(scene, SensorTarget::kMover);
  const double peak_m = SolveSteadyState(scene).mover_peak_m;
  for (const double t_s : {0.0, 1.7e-3, 0.03}) {
    EXPECT_ABS(pushed(t_s) - plain(t_s), -2.0 / 27 / 2800, 1e-9 * peak_m, "a quintic's 2e-11");
    EXPECT_ABS(MotionOf(scene, SensorTarget::kSkin)(t_s), skin(t_s), 1e-9 * peak_m,
               "a quintic's 2e-11");
  }
}

// from rest, each with one thing that the closed forms do not have
std::vector<Scene> PlayedScenes() {
  Scene plain = tests::DirectScene();
  plain.start = Start::kRest;
  std::vector<Scene> scenes(6, plain);
  scenes[0].effects.travel_stops =
      TravelStops{.gap_up_m = 5e-5, .gap_down_m = 5e-5, .restitution = 0.5};
  scenes[0].effects[Effect::kTravelStops] = Wish::kOn;
  scenes[1].effects.contact_loss = ContactLoss{0.07};
  scenes[1].effects[Effect::kContactLoss] = Wish::kAuto;
  scenes[2].finger.tones = {{.amplitude = 1e-4, .frequency_hz = 9}};
  scenes[2].effects[Effect::kTremor] = Wish::kOn;
  scenes[3].initial.mover_m = 1e-4;
  scenes[4].effects.stiffening = StiffeningSpring{.cubic_n_per_m3 = 3e10};
  scenes[4].effects[Effect::kStiffening] = Wish::kOn;
  scenes[5].drive = {.amplitude_v = 4, .kind = DriveKind::kPulse, .hold_s = 7e-3};
  return scenes;
}

EffectiveScene WithAllEffects(const Scene& scene) {
  EffectSet on;
  for (std::size_t k = 0; k < on.size(); ++k) on[k] = scene.effects.wishes[k] != Wish::kOff;
  return WithEffects(scene, on);
}

TEST(Motion, OfEachEffectIsItsWaveforms) {
  Scene plain = tests::DirectScene();
  plain.start = Start::kRest;
  const trial::Displacement without = MotionOf(plain, SensorTarget::kMover);
  for (const Scene& scene : PlayedScenes()) {
    const EffectiveScene effective = WithAllEffects(scene);
    const double rate_hz = effective.RateHz();
    const Waveforms waves =
        PlayWaveforms(effective, BeginningOf(effective), 400 / rate_hz, rate_hz);
    const trial::Displacement skin = MotionOf(scene, SensorTarget::kSkin);
    const trial::Displacement mover = MotionOf(scene, SensorTarget::kMover);
    const double largest_m = waves.mover_m.cwiseAbs().maxCoeff();
    double apart_m = 0;
    for (const Eigen::Index row : {0, 1, 37, 200, 399}) {
      const double t_s = static_cast<double>(row) / rate_hz;
      EXPECT_ABS(skin(t_s), waves.skin_m(row), 1e-11 * largest_m, "one motion, rounding of times");
      EXPECT_ABS(mover(t_s), waves.mover_m(row), 1e-11 * largest_m, "rounding of times");
      apart_m = std::max(apart_m, std::abs(mover(t_s) - without(t_s)));
    }
    EXPECT_GT(apart_m, 0.01 * largest_m) << "the effect acts";
    EXPECT_EQ(mover(-1), waves.mover_m(0)) << "before it begins";
  }
}

// 4096 outputs of some 15 kHz are kept, 0.27 s: an earlier time plays the motion again
TEST(Motion, ThatIsPlayedAgainIsTheSame) {
  for (const Scene& scene : {PlayedScenes()[0], PlayedScenes()[4]}) {
    const trial::Displacement motion = MotionOf(scene, SensorTarget::kMover);
    const double early_m = motion(0.0123), late_m = motion(0.45);
    EXPECT_EQ(MotionOf(scene, SensorTarget::kMover)(0.45), late_m) << "nothing was asked before";
    EXPECT_EQ(motion(0.0123), early_m);
    EXPECT_EQ(motion(0.45), late_m);
    EXPECT_NE(early_m, late_m);
  }
}

TEST(SimulatedRecord, SaysWhichEffectsItIsOf) {
  const std::vector<Scene> scenes = PlayedScenes();
  const auto source = [](Scene scene) {
    scene.sensor = IdealSensor();
    return SimulateRecord(scene, 0.01).metadata.source;
  };
  const std::string exact = "simulated: scene with effects, exact solution, start from rest";
  EXPECT_EQ(source(scenes[0]), exact);
  EXPECT_EQ(source(scenes[1]), exact);
  EXPECT_EQ(source(scenes[3]), "simulated: linear scene, exact solution, start from rest");
  const std::string solved =
      "simulated: scene with effects, exponential collocation, start from rest";
  EXPECT_EQ(source(scenes[4]), solved);
  Scene warm = tests::DirectScene();
  warm.start = Start::kRest;
  warm.effects.coil_heating =
      CoilHeating{.heat_capacity_j_per_k = 1, .thermal_resistance_k_per_w = 10};
  warm.effects[Effect::kCoilHeating] = Wish::kAuto;
  EXPECT_EQ(source(warm), solved);
}

TEST(SimulatedRecord, HasAFrequencyWhereItsDriveHasOne) {
  Scene scene = SensedScene();
  scene.sensor->head.resolution_m = 2e-6;
  scene.sensor->head.averages = 3;
  scene.drive = {.amplitude_v = 4,
                 .frequency_hz = 90,
                 .kind = DriveKind::kBurst,
                 .hold_s = 7e-3,
                 .offset_v = 0.5};
  const trial::Record burst = SimulateRecord(scene, 0.01);
  EXPECT_EQ(burst.metadata.drive_frequency_hz, 90);
  EXPECT_EQ(burst.metadata.drive_amplitude_v, 4.5);
  EXPECT_EQ(burst.metadata.averages, 3);
  EXPECT_EQ(burst.metadata.sampling_s, 1e-4);
  EXPECT_EQ(burst.channels[0].resolution, 2e-6);
  EXPECT_EQ(burst.channels[0].name, "displacement");
  scene.drive.kind = DriveKind::kPulse;
  EXPECT_FALSE(SimulateRecord(scene, 0.01).metadata.drive_frequency_hz);
}

}  // namespace
}  // namespace haptometer::sim
