// Triggers: what fires them, what came before, and what a recording makes of them.
#include "acquire/recorder/trigger.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <utility>
#include <vector>

#include "tests/acquire/recorder_fixture.h"

namespace haptometer::acquire {
namespace {

using ::testing::ElementsAre;
using trial::SampleStatus;
using trial::Timing;

// OneChannel counts 0.1 um
constexpr double kThreshold_m = 10e-7;

// which of `counts` fire; a negative status of -1 marks what is no measurement
std::vector<std::size_t> Firing(TriggerKind kind, const std::vector<int>& counts) {
  TriggerSetup setup;
  setup.kind = kind;
  setup.threshold = kThreshold_m;
  TriggerWatch watch(setup, OneChannel(Timing::kArrival));
  std::vector<std::size_t> firing;
  Reading reading;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const SampleStatus status = counts[i] == -99 ? SampleStatus::kInvalid : SampleStatus::kOk;
    reading.samples = {{trial::RawValue::Counts(counts[i]), status}};
    if (watch.Fires(reading)) firing.push_back(i);
  }
  return firing;
}

TEST(TriggerWatch, LevelsFireWheneverTheyHold) {
  EXPECT_THAT(Firing(TriggerKind::kAbove, {11, 10, 12, 9}), ElementsAre(0, 2));
  EXPECT_THAT(Firing(TriggerKind::kBelow, {11, 10, 9, -12}), ElementsAre(2, 3));
}

TEST(TriggerWatch, EdgesFireWhereTheThresholdIsCrossed) {
  EXPECT_THAT(Firing(TriggerKind::kRising, {11, 12, 9, 10, 11, 12, 0, 20}), ElementsAre(4, 7));
  EXPECT_THAT(Firing(TriggerKind::kFalling, {9, 11, 10, 9, 8, 30, -30}), ElementsAre(3, 6));
}

TEST(TriggerWatch, WhatIsNoMeasurementNeitherFiresNorCountsAsTheOneBefore) {
  EXPECT_THAT(Firing(TriggerKind::kBelow, {-99, 11, -99}), ::testing::IsEmpty());
  EXPECT_THAT(Firing(TriggerKind::kRising, {11, -99, 12}), ::testing::IsEmpty());
}

TEST(TriggerWatch, WatchesItsChannelInTheUnitOfThat) {
  trial::TrialHeader header = OneChannel(Timing::kArrival);
  trial::ChannelFormat voltage = header.channels[0];
  voltage.name = "voltage";
  voltage.unit = "V";
  voltage.scale = 0.5;
  voltage.offset = -2;
  header.channels.push_back(voltage);
  TriggerSetup setup{.channel = 1, .kind = TriggerKind::kAbove, .threshold = 3};
  TriggerWatch watch(setup, header);
  EXPECT_EQ(watch.Text(), "voltage above 3 V");
  Reading reading;
  // 0.5 n - 2 is 3 at n = 10
  reading.samples = {{trial::RawValue::Counts(1'000'000'000), SampleStatus::kOk},
                     {trial::RawValue::Counts(10), SampleStatus::kOk}};
  EXPECT_FALSE(watch.Fires(reading));
  reading.samples = {{trial::RawValue::Counts(0), SampleStatus::kInvalid},
                     {trial::RawValue::Counts(11), SampleStatus::kOk}};
  EXPECT_TRUE(watch.Fires(reading));
  setup.kind = TriggerKind::kFalling;
  EXPECT_EQ(TriggerWatch(setup, header).Text(), "voltage falling through 3 V");
}

TEST(PreSamples, KeepsTheLastFewInOrder) {
  PreSamples before(3, 1);
  Reading reading;
  std::vector<std::int64_t> kept;
  const auto take = [&kept](const Reading& earlier) { kept.push_back(earlier.index); };
  for (reading.index = 0; reading.index < 2; ++reading.index) before.Keep(reading);
  before.Drain(take);
  EXPECT_THAT(kept, ElementsAre(0, 1));
  kept.clear();
  for (reading.index = 2; reading.index < 9; ++reading.index) before.Keep(reading);
  before.Drain(take);
  EXPECT_THAT(kept, ElementsAre(6, 7, 8));
  kept.clear();
  before.Drain(take);
  EXPECT_TRUE(kept.empty());
}

// the CountingSensor's value is its row number, 1 ms apart
class TriggerTest : public RecorderTest {
 protected:
  static RecordingLimits Rising(int count) {
    RecordingLimits limits;
    limits.trigger = TriggerSetup{};
    limits.trigger->threshold = count * 1e-7;
    return limits;
  }
};

TEST_F(TriggerTest, RecordsFromTheTriggerOnWithWhatCameBefore) {
  CountingSensor sensor(clock_, Timing::kArrival, 1000, Outcome::kEnd);
  RecordingLimits limits = Rising(500);
  limits.trigger->pre_samples = 20;
  limits.readings = 100;
  const auto summary = Run(sensor, limits);
  ASSERT_TRUE(summary);
  const std::vector<std::int32_t> counts = Counts(path_);
  ASSERT_EQ(counts.size(), 120U) << "100 from the trigger on, and 20 before it";
  EXPECT_EQ(counts.front(), 481);
  EXPECT_EQ(counts[20], 501) << "the first value beyond 500";
  EXPECT_EQ(counts.back(), 600);
  EXPECT_EQ(summary->triggers, 1U);
  EXPECT_EQ(summary->gaps, 0U);
  ASSERT_EQ(events_.size(), 1U);
  EXPECT_EQ(events_[0].text, "trigger 1 20 rows from here: displacement rising through 5e-05 m");
  EXPECT_EQ(events_[0].row, 0U);
}

TEST_F(TriggerTest, TheDurationCountsFromTheTrigger) {
  CountingSensor sensor(clock_, Timing::kArrival, 1000, Outcome::kEnd);
  RecordingLimits limits = Rising(500);
  limits.duration_ns = 30 * kMs;
  ASSERT_TRUE(Run(sensor, limits));
  const std::vector<std::int32_t> counts = Counts(path_);
  ASSERT_EQ(counts.size(), 30U);
  EXPECT_EQ(counts.front(), 501);
}

TEST_F(TriggerTest, AShotWithoutRowsEndsByTheClock) {
  // it begins with row 501 and lasts a second; behind row 599 the source is asked every 100 ms
  for (const auto& [shots, end_ns] : {std::pair(1U, 1600 * kMs), {2U, 5000 * kMs}}) {
    const MonotonicNs begin_ns = clock_.Now();
    CountingSensor sensor(clock_, Timing::kArrival, 600, Outcome::kNothing);
    RecordingLimits limits = Rising(500);
    limits.trigger->shots = shots;
    limits.duration_ns = 1000 * kMs;
    limits.until_ns = begin_ns + 5000 * kMs;
    const auto summary = Run(sensor, limits);
    ASSERT_TRUE(summary);
    EXPECT_EQ(summary->triggers, 1U);
    EXPECT_EQ(summary->readings, 99U);
    EXPECT_EQ(clock_.Now() - begin_ns, end_ns) << "a second trigger is waited for up to the end";
    std::filesystem::remove(path_);
  }
}

TEST_F(TriggerTest, SeveralShotsWaitForTheHoldOff) {
  CountingSensor sensor(clock_, Timing::kUniform, 1000, Outcome::kEnd);
  RecordingLimits limits = Rising(100);
  limits.trigger->kind = TriggerKind::kAbove;
  limits.trigger->shots = 3;
  limits.trigger->hold_off_ns = 200 * kMs;
  limits.readings = 10;
  const auto summary = Run(sensor, limits);
  ASSERT_TRUE(summary);
  const std::vector<std::int32_t> counts = Counts(path_);
  ASSERT_EQ(counts.size(), 30U);
  EXPECT_EQ(counts[0], 101);
  EXPECT_EQ(counts[10], 301) << "200 ms after the first trigger";
  EXPECT_EQ(counts[20], 501);
  EXPECT_EQ(summary->triggers, 3U);
  EXPECT_EQ(summary->rate_hz, 1000.0) << "the pauses between shots do not count";
  EXPECT_EQ(summary->gaps, 0U) << "what lies between shots is not missing";
}

TEST_F(TriggerTest, WithoutATriggerNothingIsRecorded) {
  CountingSensor sensor(clock_, Timing::kArrival, 400, Outcome::kEnd);
  RecordingLimits limits = Rising(500);
  limits.trigger->pre_samples = 20;
  limits.readings = 100;
  const auto summary = Run(sensor, limits);
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->readings, 0U);
  EXPECT_EQ(summary->seen, 400U);
  EXPECT_EQ(summary->triggers, 0U);
  EXPECT_TRUE(summary->source_ended);
}

TEST_F(TriggerTest, AnInterruptedTrialSaysSo) {
  CountingSensor sensor(clock_, Timing::kArrival, 1, Outcome::kNothing);
  const std::atomic<bool> stop{true};
  const auto summary = Run(sensor, Rising(500), stop);
  ASSERT_TRUE(summary);
  EXPECT_TRUE(summary->interrupted);
  Counts(path_);
  ASSERT_EQ(events_.size(), 1U);
  EXPECT_EQ(events_[0].text, "interrupted: stopped before the end that was asked for");
}

}  // namespace
}  // namespace haptometer::acquire
