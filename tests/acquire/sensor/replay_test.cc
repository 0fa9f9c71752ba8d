#include "acquire/sensor/replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "tests/acquire/recorder_fixture.h"
#include "tests/findings.h"

// Rows that come when their time has come, on a manual clock.

namespace haptometer::acquire {
namespace {

using tests::NumbersOf;

using trial::Timing;

constexpr double kAtOnce = std::numeric_limits<double>::infinity();

std::unique_ptr<Sensor> Counting(Clock& clock, Timing timing, MonotonicNs period_ns = kMs) {
  return std::make_unique<CountingSensor>(clock, timing, 1000, Outcome::kEnd, period_ns);
}

TEST(PacedSensor, ARowComesAtItsTimeOverTheSpeed) {
  for (const double speed : {1.0, 10.0, 0.5}) {
    for (const Timing timing : {Timing::kUniform, Timing::kArrival, Timing::kPolled}) {
      ManualClock clock;
      clock.Advance(123 * kNsPerS);
      PacedSensor sensor(Counting(clock, timing), speed, clock);
      const MonotonicNs begin_ns = sensor.Begin();
      Reading reading;
      for (std::int64_t row = 0; row < 1000; ++row) {
        while (sensor.Next(reading) == Outcome::kNothing) {
        }
        ASSERT_EQ(reading.index, row);
        // the reply comes half a millisecond after the request
        const double due_s =
            1e-3 * (static_cast<double>(row) + (timing == Timing::kPolled ? 0.5 : 0));
        ASSERT_EQ(clock.Now() - begin_ns, std::llround(1e9 * due_s / speed)) << row;
        if (timing != Timing::kUniform) {
          ASSERT_EQ(reading.time_ns - begin_ns, row * kMs);
        }
      }
      EXPECT_EQ(sensor.Next(reading), Outcome::kEnd);
    }
  }
}

TEST(PacedSensor, ALongPauseIsWaitedForInSlices) {
  ManualClock clock;
  PacedSensor sensor(Counting(clock, Timing::kArrival, kNsPerS), 1, clock);
  (void)sensor.Begin();
  Reading reading;
  EXPECT_EQ(sensor.Next(reading), Outcome::kReading);
  for (int slice = 1; slice < 10; ++slice) {
    EXPECT_EQ(sensor.Next(reading), Outcome::kNothing);
    EXPECT_EQ(clock.Now(), MonotonicNs{100} * slice * kMs);
  }
  EXPECT_EQ(sensor.Next(reading), Outcome::kReading);
  EXPECT_EQ(reading.index, 1);
}

TEST(PacedSensor, WithoutASpeedNothingIsWaitedFor) {
  ManualClock clock;
  PacedSensor sensor(Counting(clock, Timing::kArrival), kAtOnce, clock);
  (void)sensor.Begin();
  Reading reading;
  for (int row = 0; row < 1000; ++row) ASSERT_EQ(sensor.Next(reading), Outcome::kReading);
  EXPECT_EQ(clock.Now(), 0);
}

// rows of a paced replay are those of the trial, and it takes as long as it took
TEST_F(RecorderTest, APacedReplayIsTheSameTrial) {
  CountingSensor sensor(clock_, Timing::kPolled, 500, Outcome::kEnd);
  ASSERT_TRUE(Run(sensor, {}));
  auto replay = Replay::Open(path_);
  ASSERT_TRUE(replay) << replay.error().Text();
  PacedSensor paced(std::move(*replay), 1, clock_);
  const std::string again = directory_ / "again.bin";
  auto writer = trial::TrialWriter::Create(again, paced.header(), {}, writer_clock_);
  ASSERT_TRUE(writer);
  SingleTrial sink(*writer);
  const MonotonicNs before_ns = clock_.Now();
  ASSERT_TRUE(Record(paced, sink, clock_, kNeverStop, {}));
  EXPECT_EQ(clock_.Now() - before_ns, 499 * kMs + kMs / 2);
  EXPECT_EQ(Counts(again), CountTo(500));
  const auto a = trial::ReadRecord(path_);
  const auto b = trial::ReadRecord(again);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->record.raw_times_s, b->record.raw_times_s);
}

}  // namespace
// A recorded trial played as a sensor.
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using trial::SampleStatus;

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

TEST_F(RecorderTest, AReplayKeepsTheGapsOfItsTrial) {
  CountingSensor sensor(clock_, Timing::kArrival, 5000, Outcome::kEnd);
  sensor.gap_at = 2000;
  sensor.lost_before.assign(5000, 0);
  sensor.lost_before[3000] = 7;
  ASSERT_TRUE(Run(sensor, {}));
  auto replay = Replay::Open(path_);
  ASSERT_TRUE(replay) << replay.error().Text();
  const std::string again = directory_ / "again.bin";
  auto writer = trial::TrialWriter::Create(again, (*replay)->header(), {}, writer_clock_);
  ASSERT_TRUE(writer);
  SingleTrial sink(*writer);
  ASSERT_TRUE(Record(**replay, sink, clock_, kNeverStop, {}));
  using Missing = std::optional<std::optional<std::uint64_t>>;
  for (const std::string& path : {path_, again}) {
    const auto read = trial::ReadRecord(path);
    ASSERT_TRUE(read);
    std::vector<std::pair<std::uint64_t, Missing>> gaps;
    for (const trial::Event& event : read->report.events) {
      if (event.BeginsStretch()) gaps.emplace_back(event.row, event.missing);
    }
    ASSERT_EQ(gaps.size(), 2) << path;
    EXPECT_EQ(gaps[0].first, 2000);
    EXPECT_EQ(gaps[0].second, Missing(std::optional<std::uint64_t>()));
    EXPECT_EQ(gaps[1].first, 3000);
    EXPECT_EQ(gaps[1].second, Missing(std::optional<std::uint64_t>(7)));
    EXPECT_EQ(read->record.stretches.size(), 3);
  }
}

TEST_F(RecorderTest, AReplayMarksOnlyWhatIsMissing) {
  const CountingSensor sensor(clock_, Timing::kArrival, 0, Outcome::kEnd);
  trial::TrialWriter writer = Writer(sensor);
  SingleTrial sink(writer);
  const std::optional<std::uint64_t> unknown;
  for (std::int32_t row = 0; row < 8; ++row) {
    if (row == 2) {
      ASSERT_TRUE(sink.AddEvent({.kind = trial::EventKind::kRemark, .text = "a word"}));
    }
    if (row == 4) {
      ASSERT_TRUE(sink.AddEvent({.kind = trial::EventKind::kGap,
                                 .text = "some",
                                 .missing = std::optional<std::uint64_t>(5)}));
    }
    if (row == 6) {
      ASSERT_TRUE(
          sink.AddEvent({.kind = trial::EventKind::kGap, .text = "others", .missing = unknown}));
    }
    const std::vector<trial::Sample> samples(1, {trial::RawValue::Counts(row), {}});
    ASSERT_TRUE(sink.Append({.time_ns = row * kMs, .samples = samples}));
  }
  ASSERT_TRUE(sink.Finish());
  auto replay = Replay::Open(path_);
  ASSERT_TRUE(replay) << replay.error().Text();
  Reading reading;
  for (int row = 0; row < 8; ++row) {
    ASSERT_EQ((*replay)->Next(reading), Outcome::kReading);
    EXPECT_EQ(reading.time_ns, row * kMs);
    EXPECT_EQ(reading.lost_before, row == 4 ? 5 : 0) << row;
    EXPECT_EQ(reading.follows_gap, row == 6) << row;
  }
  EXPECT_EQ((*replay)->Next(reading), Outcome::kEnd);
}

TEST_F(RecorderTest, AReplaySaysWhatIsMissingFromItsTrial) {
  CountingSensor sensor(clock_, Timing::kArrival, 50'000, Outcome::kEnd);
  ASSERT_TRUE(Run(sensor, {}));
  fs::resize_file(path_, fs::file_size(path_) * 3 / 4);
  auto replay = Replay::Open(path_);
  ASSERT_TRUE(replay) << replay.error().Text();
  ASSERT_TRUE((*replay)->Found().Has(FindingKind::kReplayCutShort));
  EXPECT_EQ((*replay)->Found().list().front().subject, path_);
  EXPECT_THAT(NumbersOf((*replay)->Found(), FindingKind::kReplayLosses), HasSubstr("losses=1"));
}

TEST_F(RecorderTest, AReplayOfNothingIsAnswered) {
  EXPECT_EQ(Replay::Open("/no/such/trial.bin").error().cause, Cause::kCannotAnswer);
}

}  // namespace
}  // namespace haptometer::acquire
