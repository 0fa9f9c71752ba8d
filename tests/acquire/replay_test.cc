// A recorded trial played as a sensor.
#include "acquire/sensor/replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/acquire/recorder_fixture.h"

namespace haptometer::acquire {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using trial::SampleStatus;
using trial::Timing;

// --- replay ---

TEST_F(RecorderTest, AReplayIsTheSameTrialBitForBit) {
  for (const Timing timing : {Timing::kUniform, Timing::kArrival, Timing::kPolled}) {
    SCOPED_TRACE(Name(timing));
    fs::remove(path_);
    CountingSensor sensor(clock_, timing, 5000, Outcome::kEnd);
    sensor.statuses = {SampleStatus::kOk, SampleStatus::kOver};
    const auto first = Run(sensor, {});
    ASSERT_TRUE(first);
    auto replay = Replay::Open(path_);
    ASSERT_TRUE(replay) << replay.error().Text();
    EXPECT_EQ((*replay)->header().metadata.source, "replay of " + path_ + " (simulated: a test)");
    const std::string again = directory_ / (std::string(Name(timing)) + ".bin");
    auto writer = trial::TrialWriter::Create(again, (*replay)->header(), {}, writer_clock_);
    ASSERT_TRUE(writer);
    SingleTrial sink(*writer);
    const auto second = Record(**replay, sink, clock_, kNeverStop, {});
    ASSERT_TRUE(second);
    EXPECT_EQ(second->readings, 5000U);
    EXPECT_EQ(second->statuses, first->statuses);
    EXPECT_EQ(second->rate_hz, first->rate_hz);
    EXPECT_EQ(Counts(again), CountTo(5000));
    const auto a = trial::ReadRecord(path_);
    const auto b = trial::ReadRecord(again);
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->record.raw_times_s, b->record.raw_times_s);
    EXPECT_EQ(a->record.channels[0].statuses, b->record.channels[0].statuses);
    ASSERT_EQ(a->record.stretches.size(), b->record.stretches.size());
    EXPECT_EQ(a->record.stretches[0].start_s, b->record.stretches[0].start_s);
    EXPECT_EQ(a->record.stretches[0].rate_hz, b->record.stretches[0].rate_hz);
  }
}

TEST_F(RecorderTest, AReplaySaysWhatIsMissingFromItsTrial) {
  CountingSensor sensor(clock_, Timing::kArrival, 50'000, Outcome::kEnd);
  ASSERT_TRUE(Run(sensor, {}));
  fs::resize_file(path_, fs::file_size(path_) * 3 / 4);
  auto replay = Replay::Open(path_);
  ASSERT_TRUE(replay) << replay.error().Text();
  ASSERT_FALSE((*replay)->Remarks().empty());
  EXPECT_THAT((*replay)->Remarks()[0], HasSubstr("was cut short"));
}

TEST_F(RecorderTest, AReplayOfNothingIsAnswered) {
  EXPECT_EQ(Replay::Open("/no/such/trial.bin").error().cause, Cause::kCannotAnswer);
}

}  // namespace
}  // namespace haptometer::acquire
