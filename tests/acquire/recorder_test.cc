// Sensors into trials: limits, stops, losses, slow and full disks, and what the summary says.
#include "acquire/recorder/recorder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <thread>

#include "acquire/recorder/gap_counter.h"
#include "acquire/recorder/interval_statistics.h"
#include "acquire/recorder/row_queue.h"
#include "acquire/sensor/replay.h"
#include "tests/residual.h"
#include "trial/trial_reader.h"

namespace haptometer::acquire {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using trial::SampleStatus;
using trial::Timing;

constexpr MonotonicNs kMs = 1'000'000;
const std::atomic<bool> kNeverStop{false};

trial::TrialHeader OneChannel(Timing timing) {
  trial::TrialHeader header;
  header.timing = timing;
  header.rate_hz = timing == Timing::kUniform ? 1000 : 0;
  header.metadata.source = "simulated: a test";
  trial::ChannelFormat channel;
  channel.name = "displacement";
  channel.role = trial::ChannelRole::kDisplacement;
  channel.unit = "m";
  channel.encoding = trial::Encoding::kI32;
  channel.scale = 1e-7;
  header.channels = {channel};
  return header;
}

/// Row k at k * period; then silence, the end or a hang-up.
class CountingSensor final : public Sensor {
 public:
  CountingSensor(Clock& clock, Timing timing, std::uint64_t rows, Outcome then,
                 MonotonicNs period_ns = kMs)
      : clock_(clock),
        header_(OneChannel(timing)),
        rows_(rows),
        then_(then),
        period_ns_(period_ns) {}

  Result<void> Start(const std::atomic<bool>& /*stop*/) override { return {}; }
  const trial::TrialHeader& header() const override { return header_; }
  std::vector<std::string> Remarks() const override { return {}; }
  MonotonicNs Begin() override { return origin_ns_ = clock_.Now(); }
  Outcome Next(Reading& reading) override {
    if (next_ == rows_) {
      clock_.SleepUntil(clock_.Now() + 100 * kMs);
      return then_;
    }
    reading.index = static_cast<std::int64_t>(next_);
    reading.time_ns = origin_ns_ + reading.index * period_ns_;
    reading.reply_ns = reading.time_ns + kMs / 2;
    const auto status = statuses.empty() ? SampleStatus::kOk : statuses[next_ % statuses.size()];
    reading.samples = {{trial::RawValue::Counts(static_cast<std::int32_t>(next_)), status}};
    ++next_;
    return Outcome::kReading;
  }
  std::uint64_t discarded_bytes() const override { return 17; }

  std::vector<SampleStatus> statuses;  ///< in turn; empty: all ok

 private:
  Clock& clock_;
  trial::TrialHeader header_;
  std::uint64_t rows_;
  Outcome then_;
  MonotonicNs period_ns_;
  MonotonicNs origin_ns_ = 0;
  std::uint64_t next_ = 0;
};

class RecorderTest : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(directory_); }
  void TearDown() override { fs::remove_all(directory_); }
  trial::TrialWriter Writer(const Sensor& sensor) {
    auto writer = trial::TrialWriter::Create(path_, sensor.header(), {}, writer_clock_);
    EXPECT_TRUE(writer);
    return std::move(*writer);
  }
  Result<RecordingSummary> Run(Sensor& sensor, const RecordingLimits& limits,
                               const std::atomic<bool>& stop = kNeverStop) {
    trial::TrialWriter writer = Writer(sensor);
    return Record(sensor, writer, clock_, stop, limits);
  }
  // the counts of the trial, which was closed properly
  std::vector<std::int32_t> Counts(const std::string& path, bool closed = true) {
    auto reader = trial::TrialReader::Open(path);
    EXPECT_TRUE(reader);
    std::vector<std::int32_t> counts;
    while (true) {
      const auto chunk = reader->Next();
      EXPECT_TRUE(chunk);
      if (*chunk == nullptr) break;
      for (std::size_t row = 0; row < (*chunk)->rows(); ++row) {
        counts.push_back(static_cast<std::int32_t>((*chunk)->At(row, 0).raw.bits()));
      }
    }
    EXPECT_EQ(reader->report().closed, closed);
    events_ = reader->report().events;
    return counts;
  }
  static std::vector<std::int32_t> CountTo(std::int32_t n) {
    std::vector<std::int32_t> counts(static_cast<std::size_t>(n));
    for (std::int32_t i = 0; i < n; ++i) counts[static_cast<std::size_t>(i)] = i;
    return counts;
  }

  const fs::path directory_ =
      fs::path(::testing::TempDir()) / ("recorder_test_" + std::to_string(getpid()));
  const std::string path_ = directory_ / "trial.bin";
  ManualClock clock_;         // the reading thread's
  ManualClock writer_clock_;  // the writing thread's
  std::vector<trial::Event> events_;
};

TEST_F(RecorderTest, StopsAtTheNumberOfReadings) {
  CountingSensor sensor(clock_, Timing::kArrival, 1000, Outcome::kEnd);
  const auto summary = Run(sensor, {.duration_ns = {}, .readings = 250});
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->readings, 250U);
  EXPECT_EQ(summary->distinct(), 250U);
  EXPECT_EQ(summary->discarded_bytes, 17U);
  EXPECT_REL(summary->rate_hz.value(), 1000.0, 1e-15, "249 intervals in 249 ms");
  EXPECT_ABS(summary->interval_sd_s.value(), 0.0, 1e-15, "rounding of the running mean");
  EXPECT_EQ(Counts(path_), CountTo(250));
}

TEST_F(RecorderTest, StopsAtTheDurationByTheRowsTimes) {
  clock_.Advance(12'345 * kMs);  // times count from the beginning, not from the clock's zero
  CountingSensor sensor(clock_, Timing::kArrival, 1000, Outcome::kEnd);
  const auto summary = Run(sensor, {.duration_ns = 500 * kMs, .readings = {}});
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->readings, 500U) << "rows at 0 to 499 ms";
  EXPECT_EQ(Counts(path_), CountTo(500));
  const auto recording = trial::ReadRecord(path_);
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording->record.raw_times_s.front(), 0.0);
  EXPECT_ABS(recording->record.raw_times_s.back(), 0.499, 1e-12, "nanoseconds in seconds");
}

TEST_F(RecorderTest, StopsAtTheDurationWhenNoRowComes) {
  CountingSensor sensor(clock_, Timing::kArrival, 5, Outcome::kNothing);
  const auto summary = Run(sensor, {.duration_ns = 2000 * kMs, .readings = {}});
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->readings, 5U);
  EXPECT_FALSE(summary->connection_lost);
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
  std::thread stopping([&] { stop = true; });
  const auto summary = Record(sensor, writer, system, stop, {});
  stopping.join();
  EXPECT_TRUE(summary);
}

TEST_F(RecorderTest, ALostConnectionKeepsWhatCameAndSaysSo) {
  CountingSensor sensor(clock_, Timing::kPolled, 300, Outcome::kGone);
  const auto summary = Run(sensor, {.duration_ns = 10'000 * kMs, .readings = {}});
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
                     SampleStatus::kOk, SampleStatus::kBadFrame, SampleStatus::kLate};
  const auto summary = Run(sensor, {});
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->readings, 60U);
  EXPECT_EQ(summary->bad(), 30U);
  EXPECT_EQ(summary->repeated(), 10U);
  EXPECT_EQ(summary->distinct(), 20U);
  EXPECT_EQ(summary->statuses[static_cast<std::size_t>(SampleStatus::kLate)], 20U);
}

TEST_F(RecorderTest, ProgressComesTwiceASecond) {
  CountingSensor sensor(clock_, Timing::kArrival, 3, Outcome::kNothing);
  trial::TrialWriter writer = Writer(sensor);
  int calls = 0;
  const auto summary =
      Record(sensor, writer, clock_, kNeverStop, {.duration_ns = 3000 * kMs, .readings = {}},
             [&](const RecordingSummary& now) {
               ++calls;
               EXPECT_EQ(now.readings, 3U);
             });
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

TEST_F(DiskTest, AStallLosesNothing) {
  // 20 s of a 10 kHz sensor arrive while the disk takes nothing at all
  CountingSensor sensor(clock_, Timing::kArrival, 200'000, Outcome::kNothing, kMs / 10);
  trial::TrialWriter writer = WriterOnDisk(sensor);
  disk_.Set(Disk::State::kStalls);
  const auto summary =
      Record(sensor, writer, clock_, kNeverStop, {.duration_ns = 60'000 * kMs, .readings = {}},
             [&](const RecordingSummary& now) {
               if (now.readings == 200'000) disk_.Set(Disk::State::kTakes);
             });
  ASSERT_TRUE(summary) << summary.error().Text();
  EXPECT_EQ(summary->readings, 200'000U);
  EXPECT_EQ(writer.totals().rows, 200'000U);
  EXPECT_EQ(writer.totals().rows_kept, 200'000U);
}

TEST_F(DiskTest, ADiskThatStaysTooSlowStopsTheRecordingAndKeepsWhatItHas) {
  CountingSensor sensor(clock_, Timing::kArrival, 200'000, Outcome::kEnd);
  trial::TrialWriter writer = WriterOnDisk(sensor);
  const auto summary =
      Record(sensor, writer, clock_, kNeverStop,
             {.duration_ns = {}, .readings = {}, .most_waiting_rows = 0});  // any row is too many
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().cause, Cause::kFailed);
  EXPECT_THAT(summary.error().Text(),
              HasSubstr("the disk is slower than the sensor: stopped after 0 "
                        "readings, which are kept; record to a faster"));
}

TEST_F(DiskTest, AFullDiskIsReportedInTheWritersWords) {
  CountingSensor sensor(clock_, Timing::kArrival, 200'000, Outcome::kNothing);
  trial::TrialWriter writer = WriterOnDisk(sensor);
  disk_.Set(Disk::State::kIsFull);
  const auto summary =
      Record(sensor, writer, clock_, kNeverStop, {.duration_ns = 300'000 * kMs, .readings = {}});
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().cause, Cause::kFailed);
  EXPECT_THAT(summary.error().Text(), HasSubstr("disk.bin: could not be written: No space left"));
  EXPECT_THAT(summary.error().Text(), HasSubstr("0 of "));
}

// --- queue ---

TEST(RowQueue, HandsOverEveryRowInOrderBetweenTwoThreads) {
  RowQueue queue(1'000'000);
  constexpr std::int32_t kRows = 50'000;
  std::thread writing([&] {
    RowBatch batch;
    std::int32_t expected = 0;
    while (queue.Take(batch)) {
      for (std::size_t row = 0; row < batch.rows.size(); ++row) {
        const trial::Row whole = batch.RowOf(row);
        ASSERT_EQ(whole.samples.size(), 2U);
        ASSERT_EQ(whole.time_ns, expected);
        ASSERT_EQ(whole.samples[1].raw.bits(), static_cast<std::uint64_t>(2 * expected));
        ++expected;
      }
    }
    EXPECT_EQ(expected, kRows);
  });
  Reading reading;
  for (std::int32_t i = 0; i < kRows; ++i) {
    reading.time_ns = 1000 + i;
    reading.samples = {{trial::RawValue::Counts(i), SampleStatus::kOk},
                       {trial::RawValue::Counts(2 * i), SampleStatus::kOk}};
    EXPECT_TRUE(queue.Push(reading, 1000));
  }
  queue.Close();
  writing.join();
}

TEST(RowQueue, RefusesWhenFullOrGivenUp) {
  Reading reading;
  reading.samples = {{trial::RawValue::Counts(1), SampleStatus::kOk}};
  RowQueue full(2);
  EXPECT_TRUE(full.Push(reading, 0));
  EXPECT_TRUE(full.Push(reading, 0));
  EXPECT_FALSE(full.Push(reading, 0));
  RowQueue given_up(2);
  given_up.GiveUp();
  EXPECT_FALSE(given_up.Push(reading, 0));
}

// --- statistics ---

TEST(IntervalStatistics, AgainstTheDefinition) {
  IntervalStatistics statistics;
  const std::vector<MonotonicNs> times_ns{0, 10 * kMs, 22 * kMs, 30 * kMs, 45 * kMs};
  for (const MonotonicNs time_ns : times_ns) statistics.Add(time_ns);
  // intervals 10, 12, 8, 15 ms: mean 11.25, squared deviations 1.5625 + 0.5625 + 10.5625 + 14.0625
  EXPECT_REL(statistics.RateHz().value(), 4 / 0.045, 1e-15, "one division");
  EXPECT_REL(statistics.DeviationSeconds().value(), std::sqrt(26.75 / 3) * 1e-3, 1e-12,
             "four roundings of the recurrence");
}

TEST(IntervalStatistics, ALongRecordingKeepsItsDigits) {
  // a million intervals of 100 us, every second one 1 ns longer and the next shorter: sd 1 ns
  IntervalStatistics statistics;
  MonotonicNs time_ns = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    statistics.Add(time_ns);
    time_ns += 100'000 + (i % 2 == 0 ? 1 : -1);
  }
  EXPECT_REL(statistics.DeviationSeconds().value(), 1e-9, 1e-5, "1/n, and 1e-16 of 100 us n times");
}

// --- gaps ---

class Gaps {
 public:
  explicit Gaps(Timing timing) : counter_(timing) {}
  // `rows` more, `period_ns` apart, the first `first_after_ns` behind the last one so far
  void Rows(int rows, MonotonicNs period_ns, MonotonicNs first_after_ns) {
    for (int i = 0; i < rows; ++i) {
      reading_.time_ns += i == 0 ? first_after_ns : period_ns;
      ++reading_.index;
      counter_.Add(reading_);
    }
  }
  void Skip(std::int64_t rows) { reading_.index += rows; }
  [[nodiscard]] std::uint64_t Count() const { return counter_.gaps(); }

 private:
  GapCounter counter_;
  Reading reading_;
};

TEST(GapCounter, AUniformGridHasAGapWhereTheIndexJumps) {
  Gaps gaps(Timing::kUniform);
  gaps.Rows(10, 0, 0);
  EXPECT_EQ(gaps.Count(), 0U);
  gaps.Skip(1);
  gaps.Rows(10, 0, 0);
  EXPECT_EQ(gaps.Count(), 1U);
}

TEST(GapCounter, APolledSensorHasAGapAfterEightUsualIntervals) {
  Gaps gaps(Timing::kPolled);
  gaps.Rows(100, 8 * kMs, 0);
  gaps.Rows(100, 8 * kMs, 60 * kMs);
  EXPECT_EQ(gaps.Count(), 0U);
  for (int i = 0; i < 20; ++i) gaps.Rows(10, 8 * kMs, 1000 * kMs);
  EXPECT_EQ(gaps.Count(), 20U) << "gaps do not become the usual interval";
}

TEST(GapCounter, AStallAfterWhichAllArrivesIsNoGap) {
  Gaps gaps(Timing::kArrival);
  gaps.Rows(20'000, kMs / 10, 0);
  gaps.Rows(3'000, 0, 300 * kMs);  // 300 ms of lines at one instant
  gaps.Rows(20'000, kMs / 10, kMs / 10);
  EXPECT_EQ(gaps.Count(), 0U);
}

TEST(GapCounter, ASilenceThatNothingMakesUpForIsAGap) {
  Gaps gaps(Timing::kArrival);
  for (int i = 0; i < 5; ++i) gaps.Rows(20'000, kMs / 10, 300 * kMs);
  EXPECT_EQ(gaps.Count(), 4U);
}

TEST(GapCounter, BurstsOfUsbAreNoGaps) {
  Gaps gaps(Timing::kArrival);
  for (int burst = 0; burst < 500; ++burst) gaps.Rows(160, 0, 16 * kMs);
  EXPECT_EQ(gaps.Count(), 0U);
}

TEST(GapCounter, TheEndDecidesWhatIsStillOpen) {
  Gaps lost(Timing::kArrival);
  lost.Rows(1000, kMs, 0);
  lost.Rows(50, kMs, 300 * kMs);
  EXPECT_EQ(lost.Count(), 1U);
  Gaps stalled(Timing::kArrival);
  stalled.Rows(1000, kMs, 0);
  stalled.Rows(300, 0, 300 * kMs);
  EXPECT_EQ(stalled.Count(), 0U);
}

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
    const auto second = Record(**replay, *writer, clock_, kNeverStop, {});
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
