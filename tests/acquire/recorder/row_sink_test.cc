// One trial after the other: no row lost or doubled between them, each complete in itself.
#include "acquire/recorder/row_sink.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/acquire/recorder_fixture.h"
#include "trial/block.h"

namespace haptometer::acquire {
namespace {

using trial::Timing;

class RotationTest : public RecorderTest {
 protected:
  std::string Part(std::uint64_t part) const {
    return directory_ / ("part_" + std::to_string(part) + ".bin");
  }
  Result<RecordingSummary> RunParts(Sensor& sensor, RotationLimits limits) {
    auto rotation = TrialRotation::Begin([this](std::uint64_t part) { return Part(part); },
                                         sensor.header(), limits, writer_clock_);
    EXPECT_TRUE(rotation);
    auto summary = Record(sensor, **rotation, clock_, kNeverStop, {});
    last_file_ = (*rotation)->file();
    return summary;
  }
  std::string last_file_;
};

TEST_F(RotationTest, NoRowIsLostOrDoubledBetweenParts) {
  for (const Timing timing : {Timing::kUniform, Timing::kArrival, Timing::kPolled}) {
    SCOPED_TRACE(Name(timing));
    CountingSensor sensor(clock_, timing, 1000, Outcome::kEnd);
    ASSERT_TRUE(RunParts(sensor, {.duration_ns = 300 * kMs}));
    EXPECT_EQ(last_file_, Part(4));
    std::vector<std::int32_t> all;
    for (std::uint64_t part = 1; part <= 4; ++part) {
      const std::vector<std::int32_t> counts = Counts(Part(part));
      EXPECT_EQ(counts.size(), part == 4 ? 100U : 300U);
      all.insert(all.end(), counts.begin(), counts.end());
      std::filesystem::remove(Part(part));
    }
    EXPECT_EQ(all, CountTo(1000));
  }
}

TEST_F(RotationTest, APartBeginsWhenItIsAskedFor) {
  const CountingSensor sensor(clock_, Timing::kArrival, 0, Outcome::kEnd);
  auto rotation = TrialRotation::Begin([this](std::uint64_t part) { return Part(part); },
                                       sensor.header(), {}, writer_clock_);
  ASSERT_TRUE(rotation);
  (*rotation)->RotateAtNextRow();  // not before the part has a row
  for (std::int32_t i = 0; i < 5; ++i) {
    const std::vector<trial::Sample> samples(sensor.header().channels.size(),
                                             {trial::RawValue::Counts(i), {}});
    if (i == 3) (*rotation)->RotateAtNextRow();
    ASSERT_TRUE((*rotation)->Append({.time_ns = i * kMs, .samples = samples}));
  }
  ASSERT_TRUE((*rotation)->Finish());
  EXPECT_EQ(Counts(Part(1)), (std::vector<std::int32_t>{0}));
  EXPECT_EQ(Counts(Part(2)), (std::vector<std::int32_t>{1, 2}));
  EXPECT_EQ(Counts(Part(3)), (std::vector<std::int32_t>{3, 4}));
}

TEST_F(RotationTest, EachPartCountsItsOwnTimeAndNamesTheOneBefore) {
  clock_.Advance(77 * kMs);
  CountingSensor sensor(clock_, Timing::kArrival, 1000, Outcome::kEnd);
  sensor.metadata().notes = {"the disk had no room before"};
  ASSERT_TRUE(RunParts(sensor, {.duration_ns = 300 * kMs}));
  EXPECT_EQ(trial::ReadRecord(Part(1))->record.metadata.notes, sensor.metadata().notes);
  const auto recording = trial::ReadRecord(Part(2));
  ASSERT_TRUE(recording);
  EXPECT_TRUE(recording->record.metadata.notes.empty()) << "it was not before this part";
  EXPECT_EQ(recording->record.raw_times_s.front(), 0.0);
  const auto& fields = recording->record.metadata.fields;
  EXPECT_EQ(fields.at("part"), "2");
  EXPECT_EQ(fields.at("part_start_s"), "0.300000000");
  EXPECT_EQ(fields.at("continues"), Part(1));
}

TEST_F(RotationTest, AUniformPartBeginsItsGridAnew) {
  CountingSensor sensor(clock_, Timing::kUniform, 500, Outcome::kEnd);
  ASSERT_TRUE(RunParts(sensor, {.duration_ns = 300 * kMs}));
  const auto recording = trial::ReadRecord(Part(2));
  ASSERT_TRUE(recording);
  ASSERT_EQ(recording->record.stretches.size(), 1U);
  EXPECT_EQ(recording->record.stretches[0].start_s, 0.0);
  EXPECT_EQ(recording->record.rows, 200U);
  const auto& fields = recording->record.metadata.fields;
  EXPECT_EQ(fields.at("part_start_s"), "0.300000000") << "row 300 of 1000 a second";
}

TEST_F(RotationTest, EventsAndRepliesCountFromTheirPart) {
  const CountingSensor sensor(clock_, Timing::kPolled, 0, Outcome::kEnd);
  auto rotation = TrialRotation::Begin([this](std::uint64_t part) { return Part(part); },
                                       sensor.header(), {}, writer_clock_);
  ASSERT_TRUE(rotation);
  const std::vector<trial::Sample> samples{{trial::RawValue::Counts(1), {}}};
  for (const MonotonicNs time_ns : {0 * kMs, 400 * kMs}) {
    (*rotation)->RotateAtNextRow();
    ASSERT_TRUE((*rotation)->AddEvent({.time_ns = time_ns + 100 * kMs, .text = "before the row"}));
    ASSERT_TRUE((*rotation)->Append(
        {.time_ns = time_ns, .reply_ns = time_ns + 7 * kMs, .samples = samples}));
    ASSERT_TRUE((*rotation)->AddEvent({.time_ns = time_ns + 150 * kMs, .text = "behind the row"}));
  }
  ASSERT_TRUE((*rotation)->Finish());
  Counts(Part(1));
  ASSERT_EQ(events_.size(), 3U);
  EXPECT_EQ(events_[2].time_ns, 500 * kMs) << "the part was not over";
  Counts(Part(2));
  ASSERT_EQ(events_.size(), 1U);
  EXPECT_EQ(events_[0].time_ns, 150 * kMs);
  auto reader = trial::TrialReader::Open(Part(2));
  ASSERT_TRUE(reader);
  const auto chunk = reader->Next();
  ASSERT_TRUE(chunk && *chunk != nullptr);
  EXPECT_EQ((*chunk)->TimeNs(0), 0);
  EXPECT_EQ((*chunk)->ReplyNs(0), 7 * kMs);
}

TEST_F(RotationTest, BytesAreThoseOfTheRows) {
  CountingSensor sensor(clock_, Timing::kArrival, 250, Outcome::kEnd);
  // 8 bytes of time, 4 of counts and 1 of status, padded to 16: see docs/reference/formats.md
  ASSERT_TRUE(RunParts(sensor, {.bytes = 1600}));
  EXPECT_EQ(Counts(Part(1)).size(), 1600U / trial::LayoutOf(sensor.header()).row_bytes);
}

TEST_F(RotationTest, AFileThatIsInTheWayEndsTheRecordingWithItsName) {
  std::ofstream(Part(2)) << "mine";
  CountingSensor sensor(clock_, Timing::kArrival, 1000, Outcome::kEnd);
  const auto summary = RunParts(sensor, {.duration_ns = 300 * kMs});
  ASSERT_FALSE(summary);
  EXPECT_THAT(summary.error().Text(), ::testing::HasSubstr(Part(2)));
  EXPECT_EQ(Counts(Part(1)).size(), 300U);
}

}  // namespace
}  // namespace haptometer::acquire
