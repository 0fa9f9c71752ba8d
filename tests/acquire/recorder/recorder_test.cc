// Sensors into trials: limits, stops, losses, slow and full disks, and what the summary says.
#include "acquire/recorder/recorder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

#include "acquire/recorder/recording_statistics.h"
#include "tests/acquire/recorder_fixture.h"
#include "tests/residual.h"

namespace haptometer::acquire {
namespace {

using ::testing::HasSubstr;
using trial::SampleStatus;
using trial::Timing;

TEST_F(RecorderTest, StopsAtTheNumberOfReadings) {
  CountingSensor sensor(clock_, Timing::kArrival, 1000, Outcome::kEnd);
  const auto summary = Run(sensor, {.readings = 250});
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->readings, 250U);
  EXPECT_EQ(summary->distinct(), 250U);
  EXPECT_REL(summary->elapsed_s, 0.249, 1e-15, "a quotient");
  EXPECT_EQ(summary->discarded_bytes, 17U);
  EXPECT_REL(summary->rate_hz.value(), 1000.0, 1e-15, "249 intervals in 249 ms");
  EXPECT_ABS(summary->interval_sd_s.value(), 0.0, 1e-15, "rounding of the running mean");
  EXPECT_EQ(Counts(path_), CountTo(250));
}

TEST_F(RecorderTest, StopsAtTheDurationByTheRowsTimes) {
  clock_.Advance(12'345 * kMs);  // times count from the beginning, not from the clock's zero
  CountingSensor sensor(clock_, Timing::kArrival, 1000, Outcome::kEnd);
  const auto summary = Run(sensor, {.duration_ns = 500 * kMs});
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->readings, 500U) << "rows at 0 to 499 ms";
  EXPECT_EQ(Counts(path_), CountTo(500));
  const auto recording = trial::ReadRecord(path_);
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording->record.raw_times_s.front(), 0.0);
  EXPECT_ABS(recording->record.raw_times_s.back(), 0.499, 1e-12, "nanoseconds in seconds");
}

TEST_F(RecorderTest, WhatTheSensorFindsAtTheEndIsARemarkOfTheTrial) {
  CountingSensor sensor(clock_, Timing::kArrival, 10, Outcome::kEnd);
  trial::TrialWriter writer = Writer(sensor);
  SingleTrial sink(writer);
  const auto say = [](const Finding& found) {
    return found.kind == FindingKind::kWireErrors ? std::string("errors on the wire") : "cut short";
  };
  ASSERT_TRUE(Record(sensor, sink, clock_, kNeverStop, {}, {.say = say}));
  EXPECT_EQ(Counts(path_), CountTo(10));
  ASSERT_EQ(events_.size(), 1U);
  EXPECT_EQ(events_[0].kind, trial::EventKind::kRemark);
  EXPECT_EQ(events_[0].text, "doubt: errors on the wire");
}

// 1000 rows, the last at 0.999 s
TEST_F(RecorderTest, ASourceThatGivesLessThanWasAskedForEndsEarly) {
  const auto ends_early = [&](const RecordingLimits& limits) {
    CountingSensor sensor(clock_, Timing::kArrival, 1000, Outcome::kEnd);
    const auto summary = Run(sensor, limits).value();
    EXPECT_EQ(summary.interrupted, summary.source_ended);
    Counts(path_);
    const bool is_told = std::ranges::any_of(
        events_, [](const trial::Event& event) { return event.text == trial::kInterruptedText; });
    EXPECT_EQ(is_told, summary.interrupted) << "the trial holds it too";
    std::filesystem::remove(path_);
    return summary.source_ended;
  };
  EXPECT_FALSE(ends_early({}));
  EXPECT_FALSE(ends_early({.readings = 1000}));
  EXPECT_TRUE(ends_early({.readings = 1001}));
  EXPECT_FALSE(ends_early({.duration_ns = 1000 * kMs}));
  // 0.999 s and an interval and a half, of 99 %
  EXPECT_FALSE(ends_early({.duration_ns = 1010 * kMs}));
  EXPECT_TRUE(ends_early({.duration_ns = 1011 * kMs}));
  // with a trigger of each shot: it fires at row 501, and 499 rows are left
  const TriggerSetup trigger{.threshold = 500e-7};
  EXPECT_FALSE(ends_early({.readings = 499, .trigger = trigger}));
  EXPECT_TRUE(ends_early({.readings = 500, .trigger = trigger}));
  EXPECT_FALSE(ends_early({.duration_ns = 504 * kMs, .trigger = trigger}));
  EXPECT_TRUE(ends_early({.duration_ns = 506 * kMs, .trigger = trigger}));
  EXPECT_TRUE(ends_early({.readings = 10, .trigger = TriggerSetup{.threshold = 1}})) << "no shot";
}

TEST_F(RecorderTest, StopsAtTheDurationWhenNoRowComes) {
  clock_.Advance(12'345 * kMs);
  CountingSensor sensor(clock_, Timing::kArrival, 5, Outcome::kNothing);
  const auto summary = Run(sensor, {.duration_ns = 2000 * kMs});
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->readings, 5U);
  EXPECT_FALSE(summary->connection_lost);
  EXPECT_EQ(clock_.Now(), 14'345 * kMs);
  EXPECT_EQ(summary->gaps, 1U) << "a silence of 2 s after five rows 1 ms apart";
}

// rows up to 99 ms, and the stop 500 or 1000 ms after the beginning
TEST_F(RecorderTest, AStopInASilenceEndsIt) {
  clock_.Advance(77 * kMs);
  CountingSensor sensor(clock_, Timing::kArrival, 100, Outcome::kNothing);
  trial::TrialWriter writer = Writer(sensor);
  SingleTrial sink(writer);
  std::atomic<bool> stop{false};
  const auto summary =
      Record(sensor, sink, clock_, stop, {}, {.progress = [&](const RecordingSummary& now) {
               EXPECT_EQ(now.gaps, 0U) << "it may still be made up for";
               stop = true;
             }});
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->gaps, 1U);
}

// the clock stands at the beginning, rows are up to 99 ms: nothing is missing behind them
TEST_F(RecorderTest, AStopAtTheLastRowIsNoGap) {
  clock_.Advance(77 * kMs);
  CountingSensor sensor(clock_, Timing::kArrival, 1000, Outcome::kNothing);
  trial::TrialWriter writer = Writer(sensor);
  SingleTrial sink(writer);
  std::atomic<bool> stop{false};
  const auto summary = Record(sensor, sink, clock_, stop, {},
                              {.reading = [&](const Reading& now) { stop = now.index == 99; }});
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->readings, 100U);
  EXPECT_EQ(summary->gaps, 0U);
}

// a hang-up 100 ms after 300 rows; a source that waits has the time of its rows
TEST_F(RecorderTest, AnEventHasTheTimeSinceTheBeginning) {
  clock_.Advance(77 * kMs);
  for (const bool waits : {false, true}) {
    CountingSensor sensor(clock_, Timing::kArrival, 300, Outcome::kGone);
    sensor.waits_for_us = waits;
    ASSERT_TRUE(Run(sensor, {}));
    (void)Counts(path_);
    ASSERT_EQ(events_.size(), 1U);
    EXPECT_EQ(events_[0].time_ns, (waits ? 299 : 100) * kMs);
    std::filesystem::remove(path_);
  }
}

TEST_F(RecorderTest, StopsAtAnInstantOfTheClock) {
  // a source without a row is asked every 100 ms
  for (const auto& [after_ns, end_ns] :
       {std::pair(300 * kMs, 300 * kMs), {300 * kMs + 1, 400 * kMs}}) {
    const MonotonicNs begin_ns = clock_.Now();
    CountingSensor sensor(clock_, Timing::kArrival, 5, Outcome::kNothing);
    const auto summary = Run(sensor, {.until_ns = begin_ns + after_ns});
    ASSERT_TRUE(summary);
    EXPECT_EQ(clock_.Now() - begin_ns, end_ns);
    EXPECT_EQ(summary->readings, 5U);
    EXPECT_TRUE(summary->fell_silent) << "5 ms of rows";
    std::filesystem::remove(path_);
  }
}

TEST_F(RecorderTest, AStopIsAnInterruptionWhereAnEndWasAskedFor) {
  const std::atomic<bool> stop{true};
  const auto is_interrupted = [&](const RecordingLimits& limits) {
    CountingSensor sensor(clock_, Timing::kArrival, 5, Outcome::kNothing);
    const bool interrupted = Run(sensor, limits, stop).value().interrupted;
    std::filesystem::remove(path_);
    return interrupted;
  };
  EXPECT_FALSE(is_interrupted({}));
  EXPECT_TRUE(is_interrupted({.duration_ns = 1000 * kMs}));
  EXPECT_TRUE(is_interrupted({.readings = 10}));
  EXPECT_TRUE(is_interrupted({.until_ns = clock_.Now() + kNsPerS}));
  EXPECT_TRUE(is_interrupted({.trigger = TriggerSetup{}}));
}

TEST_F(RecorderTest, StopsAtTheFlagAndFinishesTheFile) {
  std::atomic<bool> stop{true};
  CountingSensor sensor(clock_, Timing::kArrival, 5, Outcome::kNothing);
  const auto summary = Run(sensor, {}, stop);
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->readings, 0U);
  EXPECT_EQ(summary->rate_hz, std::nullopt);
  EXPECT_EQ(summary->interval_sd_s, std::nullopt);
  EXPECT_TRUE(Counts(path_).empty());
}

TEST_F(RecorderTest, AnotherThreadsFlagStopsARecordingWithoutLimits) {
  SystemClock system;
  CountingSensor sensor(system, Timing::kArrival, 5, Outcome::kNothing);
  std::atomic<bool> stop{false};
  trial::TrialWriter writer = Writer(sensor);
  SingleTrial sink(writer);
  std::thread stopping([&] { stop = true; });
  const auto summary = Record(sensor, sink, system, stop, {});
  stopping.join();
  EXPECT_TRUE(summary);
}

TEST_F(RecorderTest, ALostConnectionKeepsWhatCameAndSaysSo) {
  CountingSensor sensor(clock_, Timing::kPolled, 300, Outcome::kGone);
  const auto summary = Run(sensor, {.duration_ns = 10'000 * kMs});
  ASSERT_TRUE(summary);
  EXPECT_TRUE(summary->connection_lost);
  EXPECT_EQ(Counts(path_), CountTo(300));
  ASSERT_EQ(events_.size(), 1U);
  EXPECT_EQ(events_[0].text, "the connection was lost");
  EXPECT_EQ(events_[0].row, 300U);
}

TEST_F(RecorderTest, CountsByStatus) {
  CountingSensor sensor(clock_, Timing::kPolled, 60, Outcome::kEnd);
  sensor.statuses = {SampleStatus::kOk, SampleStatus::kRepeated, SampleStatus::kLate,
                     SampleStatus::kOk, SampleStatus::kBadFrame, SampleStatus::kOk};
  const auto summary = Run(sensor, {});
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->readings, 60U);
  EXPECT_EQ(summary->bad(), 20U);
  EXPECT_EQ(summary->measured, 40U) << "ok and repeated";
  EXPECT_EQ(summary->repeated(), 10U);
  EXPECT_EQ(summary->distinct(), 30U);
  EXPECT_EQ(summary->statuses[static_cast<std::size_t>(SampleStatus::kLate)], 10U);
}

TEST_F(RecorderTest, ProgressComesTwiceASecond) {
  CountingSensor sensor(clock_, Timing::kArrival, 3, Outcome::kNothing);
  trial::TrialWriter writer = Writer(sensor);
  SingleTrial sink(writer);
  int calls = 0;
  const auto summary = Record(sensor, sink, clock_, kNeverStop, {.duration_ns = 3000 * kMs},
                              {.progress = [&](const RecordingSummary& now) {
                                ++calls;
                                EXPECT_EQ(now.readings, 3U);
                              }});
  EXPECT_TRUE(summary);
  EXPECT_EQ(calls, 5);  // at 0.5, 1.0, ... 2.5 s; the recording ends at 3.0 s
}

// --- disks ---

/// What a disk does, told from outside.
class Disk {
 public:
  enum class State : std::uint8_t { kTakes, kStalls, kIsFull };

  void Set(State state) {
    const std::lock_guard lock(mutex_);
    state_ = state;
    changed_.notify_all();
  }
  Result<std::size_t> Take(std::size_t bytes) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return state_ != State::kStalls; });
    if (state_ == State::kIsFull) return Failed("", "No space left on device");
    return bytes;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  State state_ = State::kTakes;
};

class DiskSink final : public trial::ByteSink {
 public:
  explicit DiskSink(Disk& disk) : disk_(disk) {}
  Result<std::size_t> WriteSome(std::span<const std::byte> bytes) override {
    return disk_.Take(bytes.size());
  }
  Result<void> Sync() override { return {}; }

 private:
  Disk& disk_;
};

class DiskTest : public RecorderTest {
 protected:
  trial::TrialWriter WriterOnDisk(const Sensor& sensor) {
    auto writer = trial::TrialWriter::CreateIn(std::make_unique<DiskSink>(disk_), "disk.bin",
                                               sensor.header(), {}, writer_clock_);
    EXPECT_TRUE(writer);
    return std::move(*writer);
  }
  Disk disk_;
};

/// A trial whose rows are taken only while the disk takes.
class StallingSink final : public RowSink {
 public:
  StallingSink(trial::TrialWriter& writer, Disk& disk) : trial_(writer), disk_(disk) {}
  Result<void> Append(const trial::Row& row) override {
    if (auto taken = disk_.Take(0); !taken) return std::unexpected(taken.error());
    ++rows_;
    return trial_.Append(row);
  }
  Result<void> AddEvent(trial::Event event) override { return trial_.AddEvent(std::move(event)); }
  Result<void> FlushIfDue() override { return trial_.FlushIfDue(); }
  Result<void> Finish() override { return trial_.Finish(); }
  // called from the reading thread; false after ten seconds
  bool WaitForRows(int rows) const {
    for (int i = 0; i < 10'000 && rows_ < rows; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return rows_ >= rows;
  }

 private:
  SingleTrial trial_;
  Disk& disk_;
  std::atomic<int> rows_{0};
};

TEST_F(DiskTest, AStallLosesNothing) {
  // 20 s of a 10 kHz sensor arrive while the disk takes nothing at all
  CountingSensor sensor(clock_, Timing::kArrival, 200'000, Outcome::kNothing, kMs / 10);
  trial::TrialWriter writer = WriterOnDisk(sensor);
  SingleTrial sink(writer);
  disk_.Set(Disk::State::kStalls);
  const auto summary = Record(sensor, sink, clock_, kNeverStop, {.duration_ns = 60'000 * kMs},
                              {.progress = [&](const RecordingSummary& now) {
                                if (now.readings == 200'000) disk_.Set(Disk::State::kTakes);
                              }});
  ASSERT_TRUE(summary) << summary.error().Text();
  EXPECT_EQ(summary->readings, 200'000U);
  EXPECT_EQ(writer.totals().rows, 200'000U);
  EXPECT_EQ(writer.totals().rows_kept, 200'000U);
}

TEST_F(DiskTest, WhatTheRingHasNoRoomForIsCountedAndStandsInTheTrial) {
  CountingSensor sensor(clock_, Timing::kArrival, 30'000, Outcome::kNothing);
  trial::TrialWriter writer = Writer(sensor);
  StallingSink sink(writer, disk_);
  disk_.Set(Disk::State::kStalls);
  bool went_on = false;
  const auto summary =
      Record(sensor, sink, clock_, kNeverStop,
             {.duration_ns = 60'000 * kMs, .most_waiting_bytes = std::size_t{33} * 1000},
             {.reading = [&](const Reading& reading) {
               // the disk recovers after 20 000 readings, and has caught up when the next one comes
               if (reading.index != 20'000) return;
               disk_.Set(Disk::State::kTakes);
               went_on = sink.WaitForRows(1000);
             }});
  ASSERT_TRUE(summary) << summary.error().Text();
  ASSERT_TRUE(went_on);
  EXPECT_EQ(summary->readings + summary->lost, 30'000U);
  EXPECT_GE(summary->lost, 19'000U) << "20 000 came while there was room for 1000";
  EXPECT_LE(summary->gaps, summary->lost);
  const std::vector<std::int32_t> counts = Counts(path_);
  EXPECT_EQ(counts.size(), summary->readings);
  // each place where counts jump has an event that says by how much
  std::uint64_t told = 0;
  std::uint64_t missing = 0;
  for (const trial::Event& event : events_) {
    if (event.kind != trial::EventKind::kGap) continue;
    ASSERT_GT(event.row, 0U);
    ASSERT_LE(event.row, counts.size());
    const std::int32_t next = event.row == counts.size() ? 30'000 : counts[event.row];
    missing += static_cast<std::uint64_t>(next - counts[event.row - 1] - 1);
    told += std::stoull(event.text);
    ASSERT_TRUE(event.missing && *event.missing);
    EXPECT_EQ(**event.missing, std::stoull(event.text));
  }
  EXPECT_EQ(told, summary->lost);
  EXPECT_EQ(missing, summary->lost);
}

TEST_F(DiskTest, ASourceThatWaitsLosesNothingToASlowDisk) {
  CountingSensor sensor(clock_, Timing::kUniform, 30'000, Outcome::kEnd);
  sensor.waits_for_us = true;
  trial::TrialWriter writer = Writer(sensor);
  StallingSink sink(writer, disk_);
  disk_.Set(Disk::State::kStalls);
  std::thread recovering([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    disk_.Set(Disk::State::kTakes);
  });
  const auto summary =
      Record(sensor, sink, clock_, kNeverStop, {.most_waiting_bytes = std::size_t{33} * 1000});
  recovering.join();
  ASSERT_TRUE(summary) << summary.error().Text();
  EXPECT_EQ(summary->lost, 0U);
  EXPECT_EQ(Counts(path_), CountTo(30'000));
}

TEST_F(DiskTest, AFullDiskIsReportedInTheWritersWords) {
  CountingSensor sensor(clock_, Timing::kArrival, 200'000, Outcome::kNothing);
  trial::TrialWriter writer = WriterOnDisk(sensor);
  SingleTrial sink(writer);
  disk_.Set(Disk::State::kIsFull);
  const auto summary = Record(sensor, sink, clock_, kNeverStop, {.duration_ns = 300'000 * kMs});
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().cause, Cause::kFailed);
  EXPECT_THAT(summary.error().Text(), HasSubstr("disk.bin: could not be written: No space left"));
  EXPECT_THAT(summary.error().Text(), HasSubstr("0 of "));
}

TEST_F(RecorderTest, WhatTheSensorCountsAsLostIsAGapOfThatLength) {
  CountingSensor sensor(clock_, Timing::kArrival, 100, Outcome::kEnd);
  sensor.lost_before.assign(100, 0);
  sensor.lost_before[40] = 7;
  sensor.lost_before[99] = 2;  // at the very end, where no later row would tell
  const auto summary = Run(sensor, {});
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->gaps, 2U);
  EXPECT_EQ(Counts(path_), CountTo(100));
  ASSERT_EQ(events_.size(), 2U);
  EXPECT_EQ(events_[0].kind, trial::EventKind::kGap);
  EXPECT_EQ(events_[0].row, 40U);
  EXPECT_EQ(events_[0].text, "readings lost here, by the sensor's own count: 7");
  EXPECT_EQ(events_[1].row, 99U);
}

TEST_F(RecorderTest, ASilenceThatTheSensorCountsIsOneGap) {
  CountingSensor sensor(clock_, Timing::kArrival, 0, Outcome::kEnd);
  Tally tally(sensor, 0);
  Reading reading;
  reading.samples.resize(1);
  for (int row = 0; row < 2000; ++row) {
    // 300 ms of silence after a second; behind it 300 readings are missing
    reading.lost_before = row == 1000 ? 300 : 0;
    reading.time_ns = (row + (row >= 1000 ? 300 : 0)) * kMs;
    tally.Add(reading);
  }
  EXPECT_EQ(tally.Summary().gaps, 1U);
}

// 2000 rows a ms apart, from `origin_ns` on; `change` may change a reading
RecordingSummary TallyOf(const std::function<void(int row, Reading& reading)>& change,
                         MonotonicNs origin_ns = 0) {
  ManualClock clock;
  const CountingSensor sensor(clock, Timing::kArrival, 0, Outcome::kEnd);
  Tally tally(sensor, origin_ns);
  for (int row = 0; row < 2000; ++row) {
    Reading reading;
    reading.samples.resize(1);
    reading.time_ns = origin_ns + row * kMs;
    change(row, reading);
    tally.Add(reading);
  }
  return tally.Summary();
}

TEST(TallyGaps, ARowThatFollowsAGapBeginsAnew) {
  const RecordingSummary at_once =
      TallyOf([](int row, Reading& reading) { reading.follows_gap = row == 1000; });
  EXPECT_EQ(at_once.gaps, 1U) << "no silence shows it";
  const RecordingSummary late = TallyOf([](int row, Reading& reading) {
    reading.follows_gap = row == 1000;
    if (row >= 1000) reading.time_ns += 5 * kNsPerS;
  });
  EXPECT_EQ(late.gaps, 1U);
  EXPECT_REL(late.rate_hz.value(), 1000.0, 1e-12, "the gap is no interval");
}

TEST(TallyGaps, ALossThatTheTimeDoesNotHoldIsNoInterval) {
  // 300 rows at 1 ms are not 5 s: the counter has turned round
  const RecordingSummary turned = TallyOf([](int row, Reading& reading) {
    reading.lost_before = row == 1000 ? 300 : 0;
    if (row >= 1000) reading.time_ns += 5 * kNsPerS;
  });
  EXPECT_REL(turned.rate_hz.value(), 1000.0, 1e-12, "the gap is no interval");
  const RecordingSummary one = TallyOf([](int row, Reading& reading) {
    reading.lost_before = row == 1000 ? 1 : 0;
    if (row >= 1000) reading.time_ns += kMs;
  });
  EXPECT_EQ(one.gaps, 1U);
  EXPECT_REL(one.rate_hz.value(), 1000.0, 1e-12, "2000 intervals in 2 s");
}

TEST(TallyGaps, TheEndCountsFromTheBeginning) {
  for (const bool is_away : {false, true}) {
    for (const auto& [silence_ns, gaps] : {std::pair(40 * kMs, 0U), {60 * kMs, 1U}}) {
      ManualClock clock;
      const CountingSensor sensor(clock, Timing::kArrival, 0, Outcome::kEnd);
      Tally tally(sensor, 5 * kNsPerS);
      Reading reading;
      reading.samples.resize(1);
      for (int row = 0; row <= 1000; ++row) {
        reading.time_ns = 5 * kNsPerS + row * kMs;
        tally.Add(reading);
      }
      if (is_away) tally.Leave();
      tally.End(kNsPerS + silence_ns);
      EXPECT_EQ(tally.Summary().gaps, is_away ? 1U : gaps) << "an absent device has its gap";
      EXPECT_EQ(tally.Summary().is_away, is_away);
    }
  }
}

}  // namespace
}  // namespace haptometer::acquire
