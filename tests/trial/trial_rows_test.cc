// The oracle is ReadRecord: what is read by range is, bit for bit, what it puts into memory.
#include "trial/trial_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/findings.h"
#include "tests/trial/trial_file.h"
#include "trial/block.h"
#include "trial/byte_io.h"
#include "trial/import/read_recording.h"

namespace haptometer::trial {
namespace {

Result<std::unique_ptr<TrialRows>> RowsOf(const std::string& bytes, int threads = 2) {
  auto reader = TrialReader::OpenFrom(MakeMemorySource(bytes), "t.bin");
  if (!reader) return std::unexpected(reader.error());
  return TrialRows::From(std::move(*reader), "t.bin", threads);
}

ChannelFormat Channel(Encoding encoding, double scale, double offset) {
  return {
      .name = std::string(Name(encoding)), .encoding = encoding, .scale = scale, .offset = offset};
}

// the last status of the first block of rows is one that this version does not know
std::string WithLaterStatus(std::string bytes) {
  for (std::size_t at = kSignature.size(); at < bytes.size();) {
    auto head = DecodeBlockHead(BytesOfText(bytes).subspan(at, kBlockHeadBytes)).value();
    const std::size_t begin = at + kBlockHeadBytes;
    at = begin + head.payload_bytes;
    if (head.kind != BlockKind::kRows) continue;
    bytes[at - 1] = static_cast<char>(kSampleStatusCount);
    head.payload_crc = Crc32(BytesOfText(bytes).subspan(begin, head.payload_bytes));
    const auto encoded = EncodeBlockHead(head);
    std::memcpy(bytes.data() + begin - encoded.size(), encoded.data(), encoded.size());
    break;
  }
  return bytes;
}

// three encodings, every status and one of a later version, a gap in the grid, blocks of 7 rows
std::string RichTrial() {
  MemoryDisk disk;
  ManualClock clock;
  TrialHeader header{.timing = Timing::kUniform, .rate_hz = 1000};
  header.channels = {Channel(Encoding::kI32, 1e-6, 0.25), Channel(Encoding::kF32, 0.1, -3),
                     Channel(Encoding::kF64, 1, 0)};
  header.metadata.labels["subject"] = "1";
  auto writer = WriterInto(&disk, header, clock);
  for (int i = 0; i < 100; ++i) {
    const std::array<Sample, 3> samples{
        Sample{RawValue::Counts(i * 1'000'003), static_cast<SampleStatus>(i % 9)},
        Sample{RawValue::F32(static_cast<float>(i) / 3), SampleStatus::kOk},
        Sample{RawValue::Bits(0x7ff0'0000'0000'0000U + static_cast<std::uint64_t>(i)),
               SampleStatus::kRepeated}};
    EXPECT_TRUE(writer.Append({.index = i < 50 ? i : i + 3, .samples = samples}));
    if (i % 7 == 6 || i == 49) {
      EXPECT_TRUE(writer.Flush());
    }
  }
  EXPECT_TRUE(writer.AddEvent({.kind = EventKind::kLabels, .labels = {{"subject", "4"}}}));
  EXPECT_TRUE(writer.Finish());
  return WithLaterStatus(disk.bytes);
}

// every channel, read in ranges of `size` rows, against the record in memory
void ExpectSameRows(const RowSource& rows, const Record& record, std::size_t size) {
  for (std::size_t c = 0; c < record.channels.size(); ++c) {
    for (std::size_t first = 0; first < record.rows; first += size) {
      const std::size_t count = std::min(size, record.rows - first);
      std::vector<double> values(count);
      std::vector<SampleStatus> statuses(count);
      ASSERT_TRUE(rows.Read(c, first, values, statuses));
      for (std::size_t k = 0; k < count; ++k) {
        EXPECT_EQ(std::bit_cast<std::uint64_t>(values[k]),
                  std::bit_cast<std::uint64_t>(record.channels[c].values[first + k]));
        EXPECT_EQ(statuses[k], record.channels[c].statuses[first + k]);
      }
    }
  }
}

void ExpectSameHead(const Record& head, const Record& record) {
  EXPECT_EQ(head.rows, record.rows);
  EXPECT_EQ(head.timing, record.timing);
  EXPECT_EQ(head.metadata.labels, record.metadata.labels);
  ASSERT_EQ(head.channels.size(), record.channels.size());
  for (std::size_t c = 0; c < record.channels.size(); ++c) {
    EXPECT_EQ(head.channels[c].name, record.channels[c].name);
    EXPECT_TRUE(head.channels[c].values.empty() && head.channels[c].statuses.empty());
  }
  ASSERT_EQ(head.stretches.size(), record.stretches.size());
  for (std::size_t k = 0; k < record.stretches.size(); ++k) {
    EXPECT_EQ(head.stretches[k].first_row, record.stretches[k].first_row);
    EXPECT_EQ(head.stretches[k].rows, record.stretches[k].rows);
    EXPECT_EQ(head.stretches[k].start_s, record.stretches[k].start_s);
    EXPECT_EQ(head.stretches[k].rate_hz, record.stretches[k].rate_hz);
  }
}

void ExpectSameReport(const ReadReport& report, const ReadReport& expected) {
  EXPECT_EQ(report.closed, expected.closed);
  EXPECT_EQ(report.rows, expected.rows);
  EXPECT_EQ(report.events.size(), expected.events.size());
  ASSERT_EQ(report.losses.size(), expected.losses.size());
  for (std::size_t k = 0; k < report.losses.size(); ++k) {
    EXPECT_EQ(report.losses[k].kind, expected.losses[k].kind);
    EXPECT_EQ(tests::NumbersOf(FindingOfLoss(report.losses[k])),
              tests::NumbersOf(FindingOfLoss(expected.losses[k])));
  }
}

void ExpectAsReadRecord(const std::string& bytes) {
  const auto rows = RowsOf(bytes);
  const auto recording = ReadBytes(bytes);
  ASSERT_EQ(rows.has_value(), recording.has_value());
  if (!rows) return;
  ExpectSameHead((*rows)->head(), recording->record);
  ExpectSameReport((*rows)->report(), recording->report);
  for (const std::size_t size : {1U, 5U, 7U, 19U, 64U, 1000U}) {
    ExpectSameRows(**rows, recording->record, size);
  }
}

TEST(TrialRows, AreWhatReadRecordGives) { ExpectAsReadRecord(RichTrial()); }

// rows of five bytes, which are decoded several at a time; in the last block one status is not ok
std::string ShortRowsTrial(Encoding encoding) {
  MemoryDisk disk;
  ManualClock clock;
  TrialHeader header{.timing = Timing::kUniform, .rate_hz = 1000};
  header.channels = {Channel(encoding, 1e-7, 0.03)};
  auto writer = WriterInto(&disk, header, clock);
  for (int i = 0; i < 500; ++i) {
    const auto raw = encoding == Encoding::kI32
                         ? RawValue::Counts(i % 2 == 0 ? -4'000'037 * i : 3'999'971 * i)
                         : RawValue::F32(static_cast<float>(i) / -3);
    const std::array samples{Sample{raw, i == 470 ? SampleStatus::kOver : SampleStatus::kOk}};
    EXPECT_TRUE(writer.Append({.index = i, .samples = samples}));
    if (i % 67 == 66) {
      EXPECT_TRUE(writer.Flush());
    }
  }
  EXPECT_TRUE(writer.Finish());
  return disk.bytes;
}

TEST(TrialRows, OfFiveBytesToo) {
  for (const Encoding encoding : {Encoding::kI32, Encoding::kF32}) {
    const std::string trial = ShortRowsTrial(encoding);
    ExpectAsReadRecord(trial);
    // a status of a later version is no measurement
    const std::string later = WithLaterStatus(trial);
    ExpectAsReadRecord(later);
    EXPECT_EQ(ReadBytes(later)->record.channels[0].statuses[66], SampleStatus::kInvalid);
    EXPECT_TRUE(std::isnan(ReadBytes(later)->record.channels[0].values[66]));
  }
}

// two of which do not fit in 16 bytes
TEST(TrialRows, OfTenBytesToo) {
  MemoryDisk disk;
  ManualClock clock;
  TrialHeader header{.timing = Timing::kUniform, .rate_hz = 1000};
  header.channels = {Channel(Encoding::kI32, 1e-7, 0.03), Channel(Encoding::kF32, 2, -3)};
  auto writer = WriterInto(&disk, header, clock);
  for (int i = 0; i < 90; ++i) {
    const std::array samples{Sample{RawValue::Counts(i * 1'000'003), SampleStatus::kOk},
                             Sample{RawValue::F32(static_cast<float>(i) / 7),
                                    i == 77 ? SampleStatus::kUnder : SampleStatus::kOk}};
    EXPECT_TRUE(writer.Append({.index = i, .samples = samples}));
  }
  EXPECT_TRUE(writer.Finish());
  ExpectAsReadRecord(disk.bytes);
}

// The lower bytes of the counts are 0, so that none of them looks like a status; one status is not
// ok, at each place of the rows that are decoded at once.
TEST(TrialRows, OfFiveBytesWithOneStatusThatIsNotOkToo) {
  for (int bad = 0; bad < 16; ++bad) {
    MemoryDisk disk;
    ManualClock clock;
    TrialHeader header{.timing = Timing::kUniform, .rate_hz = 1000};
    header.channels = {Channel(Encoding::kI32, 1e-7, 0.03)};
    auto writer = WriterInto(&disk, header, clock);
    for (int i = 0; i < 40; ++i) {
      const std::array samples{
          Sample{RawValue::Counts(i << 24), i == bad ? SampleStatus::kOver : SampleStatus::kOk}};
      EXPECT_TRUE(writer.Append({.index = i, .samples = samples}));
    }
    EXPECT_TRUE(writer.Finish());
    ExpectAsReadRecord(disk.bytes);
  }
}

TEST(TrialRows, OfACutOrDamagedFileToo) {
  const std::string whole = RichTrial();
  for (std::size_t cut = 0; cut < whole.size(); cut += 97) {
    SCOPED_TRACE(cut);
    ExpectAsReadRecord(whole.substr(0, cut));
    std::string flipped = whole;
    flipped[cut] = static_cast<char>(flipped[cut] ^ 4);
    ExpectAsReadRecord(flipped);
  }
}

// what a record says beside its columns
Record DescribedRecord() {
  Record record;
  record.rows = 3;
  record.timing = Timing::kPolled;
  record.stretches = {{.rows = 3, .start_s = 0.5, .rate_hz = 10}};
  record.raw_times_s = {0.5, 0.61, 0.7};
  record.metadata.source = "simulated";
  record.channels = {{.name = "a",
                      .role = ChannelRole::kVoltage,
                      .unit = "V",
                      .values = {1, 2, 3},
                      .statuses = {SampleStatus::kOk, SampleStatus::kRepeated, SampleStatus::kOk},
                      .range_min = -4,
                      .range_max = 5,
                      .resolution = 0.25}};
  return record;
}

TEST(RecordRows, SayAllButTheColumns) {
  Record record = DescribedRecord();
  for (const bool are_known : {false, true}) {
    record.times_are_known = are_known;
    const RecordRows rows(record);
    const Record& head = rows.head();
    ExpectSameHead(head, record);
    EXPECT_EQ(head.times_are_known, are_known);
    EXPECT_EQ(head.raw_times_s, are_known ? record.raw_times_s : std::vector<double>{});
    EXPECT_EQ(head.metadata.source, "simulated");
    EXPECT_EQ(head.channels[0].role, ChannelRole::kVoltage);
    EXPECT_EQ(head.channels[0].unit, "V");
    EXPECT_EQ(head.channels[0].range_min, -4);
    EXPECT_EQ(head.channels[0].range_max, 5);
    EXPECT_EQ(head.channels[0].resolution, 0.25);
    for (const std::size_t size : {1U, 2U, 3U}) ExpectSameRows(rows, record, size);
    const auto all = ReadAllRows(rows);
    ASSERT_TRUE(all);
    EXPECT_EQ(all->channels[0].values, record.channels[0].values);
    EXPECT_EQ(all->channels[0].statuses, record.channels[0].statuses);
  }
}

TEST(RecordRowsDeathTest, RowsBehindTheLastAreAnErrorOfTheProgrammer) {
  const Record record = DescribedRecord();
  const RecordRows rows(record);
  std::vector<double> values(2);
  std::vector<SampleStatus> statuses(2);
  EXPECT_TRUE(rows.Read(0, 1, values, statuses));
  EXPECT_DEATH(std::ignore = rows.Read(0, 2, values, statuses), "rows 2 \\+ 2 of 3");
  EXPECT_DEATH(std::ignore = rows.Read(1, 0, values, statuses), "channel 1");
}

TEST(TrialRows, AFileThatShrinksIsAnError) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.bin");
  std::ofstream(path, std::ios::binary) << CountingTrial(1000, 100);
  const auto opened = OpenRows(path);
  ASSERT_TRUE(opened);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  std::vector<double> values(1000);
  std::vector<SampleStatus> statuses(1000);
  const auto read = opened->rows->Read(0, 0, values, statuses);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().cause, Cause::kFailed);
  EXPECT_EQ(read.error().Text(),
            path + ": was cut shorter while it was read; leave it alone meanwhile");
  EXPECT_TRUE(
      opened->rows->Read(0, 0, std::span(values).first(100), std::span(statuses).first(100)));
}

TEST(OpenRows, OpensEveryKind) {
  const ScratchDirectory directory;
  const auto open = [&](const std::string& name, const std::string& bytes) {
    std::ofstream(directory.File(name), std::ios::binary) << bytes;
    auto opened = OpenRows(directory.File(name));
    EXPECT_TRUE(opened) << (opened ? "" : opened.error().Text());
    return opened;
  };
  const auto trial = open("t.bin", CountingTrial(10, 4));
  EXPECT_NE(dynamic_cast<const TrialRows*>(trial->rows.get()), nullptr);
  EXPECT_EQ(trial->rows->head().rows, 10U);
  EXPECT_TRUE(trial->report.closed);
  const auto csv = open("t.csv", "time_s,displacement_m\n0,0.5\n0.001,0.25\n0.002,0.125\n");
  EXPECT_EQ(csv->report.kind, FileKind::kCsv);
  double value = 0;
  SampleStatus status{};
  ASSERT_TRUE(csv->rows->Read(0, 2, {&value, 1}, {&status, 1}));
  EXPECT_EQ(value, 0.125);
  // the messages are ReadRecording's
  EXPECT_EQ(OpenRows(directory.File("none")).error().what, "no such file");
}

}  // namespace
}  // namespace haptometer::trial
