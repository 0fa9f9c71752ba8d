#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "fit/adapter/adapter_fit.h"

namespace haptometer::fit {
namespace {

using ::testing::HasSubstr;

trial::Record Recording() {
  trial::Record record;
  record.rows = 3;
  record.channels = {{.name = "displacement_m",
                      .role = trial::ChannelRole::kDisplacement,
                      .unit = "m",
                      .values = {1e-3, 2e-3, 3e-3},
                      .statuses = {trial::SampleStatus::kOk, trial::SampleStatus::kClipped,
                                   trial::SampleStatus::kOk}}};
  record.stretches = {{.first_row = 0, .rows = 3, .start_s = -0.5, .rate_hz = 2000}};
  return record;
}

TEST(TapFromRecord, TakesTheDisplacementWithItsTimeBase) {
  auto recording = Recording();
  recording.channels.insert(recording.channels.begin(), {.name = "drive_v",
                                                         .role = trial::ChannelRole::kVoltage,
                                                         .unit = "V",
                                                         .values = {0, 0, 0},
                                                         .statuses = {}});
  const auto tap = TapFromRecord(recording, "tap.bin");
  ASSERT_TRUE(tap) << tap.error().Text();
  EXPECT_EQ(tap->name, "tap.bin");
  EXPECT_EQ(tap->start_s, -0.5);
  EXPECT_EQ(tap->step_s, 1.0 / 2000);
  EXPECT_EQ(tap->unit, "m");
  ASSERT_EQ(tap->voltage_v.size(), 3U);
  EXPECT_EQ(tap->voltage_v[0], 1e-3);
  EXPECT_TRUE(std::isnan(tap->voltage_v[1])) << "a clipped sample is no measurement";
  EXPECT_EQ(tap->voltage_v[2], 3e-3);
}

TEST(TapFromRecord, TakesASingleChannelOfAnyName) {
  auto recording = Recording();
  recording.channels[0].role = trial::ChannelRole::kVoltage;
  EXPECT_TRUE(TapFromRecord(recording, "tap.bin"));
}

TEST(TapFromRecord, RefusesWhatCouldBeMeantTwiceAndWhatHasGaps) {
  auto two = Recording();
  two.channels.push_back(two.channels[0]);
  EXPECT_THAT(TapFromRecord(two, "t").error().Text(), HasSubstr("several displacements"));
  two.channels[0].role = trial::ChannelRole::kVoltage;
  two.channels[1].role = trial::ChannelRole::kVoltage;
  EXPECT_THAT(TapFromRecord(two, "t").error().Text(), HasSubstr("no displacement"));
  auto gap = Recording();
  gap.stretches = {{.first_row = 0, .rows = 1, .start_s = 0, .rate_hz = 1000},
                   {.first_row = 1, .rows = 2, .start_s = 1, .rate_hz = 1000}};
  EXPECT_THAT(TapFromRecord(gap, "t").error().Text(), HasSubstr("gaps"));
  auto uneven = Recording();
  uneven.stretches[0].time_uncertainty_s = 1e-6;
  EXPECT_TRUE(TapFromRecord(uneven, "t")) << "of a clocked source they are rounded";
  uneven.timing = trial::Timing::kArrival;
  EXPECT_THAT(TapFromRecord(uneven, "t").error().Text(), HasSubstr("non-uniform"));
}

TEST(TapFromRecord, OnlyMetresAreADisplacement) {
  const auto metres = TapFromRecord(Recording(), "tap.bin");
  ASSERT_TRUE(metres);
  EXPECT_EQ(metres->signal, RecordedSignal::kDisplacement);
  auto recording = Recording();
  recording.channels[0].unit = "V";
  const auto volts = TapFromRecord(recording, "tap.bin");
  ASSERT_TRUE(volts);
  EXPECT_EQ(volts->signal, RecordedSignal::kVoltage);
  EXPECT_EQ(volts->unit, "V");
}

TEST(TapFromRecord, ReadingsThatArriveAtExactTimesAreUniform) {
  auto recording = Recording();
  recording.timing = trial::Timing::kArrival;
  EXPECT_TRUE(TapFromRecord(recording, "tap.bin"));
}

TEST(TapFromRecord, RoundedTimesAreAnUncertainTimeScale) {
  auto recording = Recording();
  EXPECT_FALSE(TapFromRecord(recording, "tap.bin")->time_scale);
  recording.stretches[0].time_uncertainty_s = 3e-6;
  const auto tap = TapFromRecord(recording, "tap.bin");
  ASSERT_TRUE(tap && tap->time_scale);
  EXPECT_EQ(tap->time_scale->value, 1);
  EXPECT_NEAR(tap->time_scale->standard_uncertainty, std::sqrt(2.0) * 3e-6 * 2000 / 3, 1e-15)
      << "of both ends over 3 rows at 2 kHz";
}

}  // namespace
}  // namespace haptometer::fit
