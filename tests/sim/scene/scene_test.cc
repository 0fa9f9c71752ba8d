#include "sim/scene/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "tests/residual.h"

namespace haptometer::sim {
namespace {

Drive Samples(double rate_hz, const std::vector<double>& voltages_v) {
  return {.kind = DriveKind::kSamples,
          .samples = std::make_shared<VoltageSamples>(VoltageSamples{rate_hz, voltages_v})};
}

// amplitude, sum of the tones', largest sample, each with the offset's magnitude
TEST(Drive, ComesToItsLargestVoltageWithItsOffset) {
  const auto largest_v = [](Drive drive, double offset_v) {
    drive.offset_v = offset_v;
    return LargestVoltageV(drive);
  };
  for (const DriveKind kind :
       {DriveKind::kSine, DriveKind::kBurst, DriveKind::kChirp, DriveKind::kPulse}) {
    EXPECT_EQ(largest_v({.amplitude_v = 5, .kind = kind}, -1.5), 6.5) << Name(kind);
    EXPECT_EQ(largest_v({.amplitude_v = -5, .kind = kind}, 1.5), 6.5) << Name(kind);
  }
  const Drive tones{.kind = DriveKind::kTones, .tones = {{2, 40, 0}, {-0.5, 90, 1}}};
  EXPECT_EQ(largest_v(tones, 0), 2.5);
  EXPECT_EQ(largest_v(tones, -0.25), 2.75);
  EXPECT_EQ(largest_v(Samples(1000, {1, -3, 2}), 0), 3);
  EXPECT_EQ(largest_v(Samples(1000, {1, -3, 2}), 0.5), 3.5);
}

TEST(Drive, HasTheHighestFrequencyOfWhatItPlays) {
  EXPECT_EQ(HighestFrequencyHz({.frequency_hz = 70, .kind = DriveKind::kBurst}), 70);
  for (const double end_hz : {60.0, 90.0}) {
    const Drive chirp{.frequency_hz = 70, .kind = DriveKind::kChirp, .end_frequency_hz = end_hz};
    EXPECT_EQ(HighestFrequencyHz(chirp), end_hz > 70 ? 90 : 70);
  }
  const Drive tones{.kind = DriveKind::kTones, .tones = {{1, 90, 0}, {1, 120, 0}, {1, 40, 0}}};
  EXPECT_EQ(HighestFrequencyHz(tones), 120);
  EXPECT_EQ(HighestFrequencyHz(Samples(1000, {1, 2})), 0);
  // a pulse has none, also where one is given
  EXPECT_EQ(HighestFrequencyHz({.frequency_hz = 70, .kind = DriveKind::kPulse}), 0);
  EXPECT_EQ(HighestFrequencyHz({.frequency_hz = 70, .kind = DriveKind::kSine}), 70);
}

// a burst, a chirp and a pulse at the sum of their parts, samples at the last of them
TEST(Drive, EndsWithItsLastPart) {
  const Drive parts{.frequency_hz = 70,
                    .kind = DriveKind::kBurst,
                    .start_s = 1,
                    .rise_s = 2,
                    .hold_s = 4,
                    .fall_s = 8,
                    .duration_s = 16};
  Drive drive = parts;
  EXPECT_EQ(EndOfDriveS(drive), 15);
  drive.kind = DriveKind::kChirp;
  EXPECT_EQ(EndOfDriveS(drive), 17);
  drive.kind = DriveKind::kPulse;
  EXPECT_EQ(EndOfDriveS(drive), 5);
  EXPECT_EQ(EndOfDriveS(Samples(4, {0, 1, 2})), 0.5);
  for (const DriveKind kind : {DriveKind::kSine, DriveKind::kTones}) {
    drive.kind = kind;
    EXPECT_TRUE(IsLasting(drive) && std::isinf(EndOfDriveS(drive)));
  }
}

TEST(Scene, StartsAsItSaysOrAsItsDriveAllows) {
  Scene scene;
  scene.drive.kind = DriveKind::kTones;
  EXPECT_EQ(StartOf(scene), Start::kSteady);
  scene.duration_s = 1;
  EXPECT_EQ(StartOf(scene), Start::kRest);
  scene.start = Start::kSteady;
  EXPECT_EQ(StartOf(scene), Start::kSteady);
  scene = {};
  scene.drive.kind = DriveKind::kBurst;
  EXPECT_EQ(StartOf(scene), Start::kRest) << "a drive that ends";
}

TEST(Scene, AnyNumberOfItsInitialStateCounts) {
  EXPECT_FALSE(InitialState{}.Any());
  for (double InitialState::* number :
       {&InitialState::mover_m, &InitialState::mover_m_per_s, &InitialState::case_m,
        &InitialState::case_m_per_s, &InitialState::skin_m, &InitialState::skin_m_per_s,
        &InitialState::current_a}) {
    InitialState state;
    state.*number = -1e-9;
    EXPECT_TRUE(state.Any());
  }
}

TEST(IdealSensor, ReadsAllThereIs) {
  const Sensor sensor = IdealSensor();
  EXPECT_EQ(sensor.rate_hz, 1e4);
  EXPECT_EQ(sensor.rate_hz * sensor.head.sampling_s, 1) << "each sample is read";
  EXPECT_TRUE(std::isinf(sensor.head.range_max_m) && std::isinf(sensor.head.range_min_m));
  EXPECT_LT(sensor.head.range_min_m, 0);
  EXPECT_EQ(sensor.head.noise_rms_m, 0);
  EXPECT_EQ(sensor.head.resolution_m, 0);
  EXPECT_EQ(sensor.latency_s, 0);
}

}  // namespace
}  // namespace haptometer::sim
