#include "trial/trial_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/findings.h"
#include "tests/trial/trial_file.h"
#include "trial/block.h"
#include "trial/import/read_recording.h"
#include "trial/trial_writer.h"

namespace haptometer::trial {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t kHead = kBlockHeadBytes;

// offsets of all blocks of a sound file
std::vector<std::size_t> BlockOffsets(const std::string& bytes) {
  std::vector<std::size_t> offsets;
  std::size_t at = kSignature.size();
  while (at < bytes.size()) {
    offsets.push_back(at);
    at += kHead + DecodeBlockHead(BytesOfText(bytes).subspan(at, kHead))->payload_bytes;
  }
  return offsets;
}

// Every value that is read must be the one that was written at its place: counts equal the place on
// the grid, 1 ms apart.
void ExpectTrueValues(const Record& record) {
  for (std::size_t row = 0; row < record.rows; ++row) {
    const double value = record.channels[0].values[row];
    const double place = std::round(TimeOf(record, row) * 1000);
    ASSERT_EQ(value, place * 1e-6 + 0.25) << "row " << row;
  }
}

// the grid's places are exact, and what was printed of a rate is not
TEST(TrialReader, AStoredTimeBaseOverridesTheGrid) {
  const ScratchDirectory folder;
  const std::string path = folder.File("t.bin");
  TrialHeader header;
  header.rate_hz = 1000;
  header.channels = {{.name = "x"}};
  const Stretch first{
      .first_row = 0, .rows = 10, .start_s = 1e-5, .rate_hz = 1000, .time_uncertainty_s = 3e-5};
  const Stretch second{
      .first_row = 10, .rows = 20, .start_s = 0.02, .rate_hz = 1000, .time_uncertainty_s = 2e-5};
  const auto write = [&](const std::vector<Stretch>& stretches) {
    ManualClock clock;
    auto writer = TrialWriter::Create(path, header, {.overwrite = true}, clock);
    ASSERT_TRUE(writer);
    const Sample sample{RawValue::Counts(1), SampleStatus::kOk};
    for (int i = 0; i < 30; ++i) {
      ASSERT_TRUE(writer->Append({.index = i < 10 ? i : i + 10, .samples = {&sample, 1}}));
    }
    for (const Stretch& stretch : stretches) {
      ASSERT_TRUE(writer->AddEvent({.kind = EventKind::kTimeBase, .stretch = stretch}));
    }
    ASSERT_TRUE(writer->Finish());
  };
  const auto expect = [&](const std::vector<double>& uncertainties_s) {
    const auto whole = ReadRecord(path);
    ASSERT_TRUE(whole);
    const auto rows = OpenRows(path);
    ASSERT_TRUE(rows);
    for (const Record* record : {&whole->record, &rows->rows->head()}) {
      ASSERT_EQ(record->stretches.size(), 2U);
      for (std::size_t s = 0; s < 2; ++s) {
        EXPECT_EQ(record->stretches[s].time_uncertainty_s, uncertainties_s[s]);
      }
      EXPECT_EQ(record->stretches[0].start_s, uncertainties_s[0] > 0 ? 1e-5 : 0);
    }
  };
  write({first, second});
  expect({3e-5, 2e-5});
  // one that is not about all rows is none
  write({first});
  expect({0, 0});
}

TEST(TrialReader, CutAtAnyByteEveryWholeBlockIsReadAndTheLossStated) {
  const std::string whole = CountingTrial(30, 10);
  const auto offsets = BlockOffsets(whole);
  ASSERT_EQ(offsets.size(), 6);  // two headers, three blocks of rows, close
  for (std::size_t cut = 0; cut < whole.size(); ++cut) {
    const auto read = ReadBytes(whole.substr(0, cut));
    if (cut < offsets[1]) {
      ASSERT_FALSE(read) << cut;
      EXPECT_EQ(read.error().cause, Cause::kCannotAnswer);
      continue;
    }
    ASSERT_TRUE(read) << cut << ": " << read.error().Text();
    std::size_t blocks = 0;
    while (blocks < 3 && offsets[blocks + 3] <= cut) ++blocks;
    EXPECT_EQ(read->record.rows, 10 * blocks) << cut;
    EXPECT_FALSE(read->report.closed);
    const bool is_between = std::ranges::find(offsets, cut) != offsets.end();
    EXPECT_EQ(read->report.losses.empty(), is_between) << cut;
    ExpectTrueValues(read->record);
  }
}

TEST(TrialReader, AnyFlippedBitIsFoundAndCostsAtMostItsBlock) {
  const std::string whole = CountingTrial(30, 10);
  const auto offsets = BlockOffsets(whole);
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    std::string flipped = whole;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << (bit % 8)));
    const auto read = ReadBytes(flipped);
    ASSERT_TRUE(read) << "bit " << bit << ": " << read.error().Text();
    // exactly one loss, covering exactly the damaged part
    ASSERT_EQ(read->report.losses.size(), 1) << bit;
    const Loss& loss = read->report.losses[0];
    EXPECT_LE(loss.offset, bit / 8);
    EXPECT_GT(loss.offset + loss.bytes, bit / 8);
    const auto after = std::ranges::upper_bound(offsets, bit / 8);
    const auto block = static_cast<std::size_t>(after - offsets.begin());  // 0: signature
    const bool in_rows = block >= 3 && block <= 5;
    EXPECT_EQ(loss.bytes,
              (block < 6 ? offsets[block] : whole.size()) - (block == 0 ? 0 : offsets[block - 1]));
    EXPECT_EQ(read->record.rows, in_rows ? 20 : 30) << bit;
    if (block < 6) {
      EXPECT_EQ(loss.rows, in_rows ? 10 : 0) << bit;
      EXPECT_TRUE(read->report.closed);
    }
    ExpectTrueValues(read->record);
  }
}

TEST(TrialReader, ALostBlockIsNamedWithItsRows) {
  std::string bytes = CountingTrial(30, 10);
  const auto offsets = BlockOffsets(bytes);
  bytes[offsets[3] + kHead + 5] ^= 1;  // payload of the second block of rows
  const Finding loss = FindingOfLoss(ReadBytes(bytes)->report.losses.at(0));
  EXPECT_EQ(loss.kind, FindingKind::kBlocksDamaged);
  EXPECT_EQ(loss.severity, Severity::kDoubt);
  EXPECT_EQ(tests::NumbersOf(loss), "block=3 from_byte=" + std::to_string(offsets[3]) +
                                        " to_byte=" + std::to_string(offsets[4] - 1) +
                                        " first_row=10 last_row=19");
  bytes[offsets[3] + 20] ^= 1;  // and its head
  const Loss of_head = ReadBytes(bytes)->report.losses.at(0);
  EXPECT_EQ(of_head.kind, FindingKind::kBlocksDamaged);
  EXPECT_EQ(of_head.block, 3U);
  EXPECT_EQ(ReadBytes(bytes)->report.RowsLost(), 10);
}

TEST(TrialReader, RemovedRepeatedAndStrangeBytesAreStated) {
  const std::string whole = CountingTrial(30, 10);
  const auto offsets = BlockOffsets(whole);
  const std::string block = whole.substr(offsets[3], offsets[4] - offsets[3]);
  std::string removed = whole;
  removed.erase(offsets[3], block.size());
  const auto without = ReadBytes(removed);
  EXPECT_EQ(without->record.rows, 20);
  ASSERT_EQ(without->report.losses.size(), 1);
  EXPECT_EQ(without->report.losses[0].kind, FindingKind::kBlocksMissing);
  EXPECT_EQ(tests::NumbersOf(FindingOfLoss(without->report.losses[0])),
            "block=3 first_row=10 last_row=19");

  std::string repeated = whole;
  repeated.insert(offsets[3], block);
  const auto twice = ReadBytes(repeated);
  EXPECT_EQ(twice->record.rows, 30);
  EXPECT_EQ(twice->report.losses.at(0).kind, FindingKind::kBlockOutOfOrder);
  ExpectTrueValues(twice->record);

  std::string strange = whole;
  strange.insert(offsets[3], std::string(200'000, '\x93'));
  const auto around = ReadBytes(strange);
  EXPECT_EQ(around->record.rows, 30);
  EXPECT_EQ(around->report.losses.at(0).bytes, 200'000);
  EXPECT_EQ(around->report.RowsLost(), 0);
}

TEST(TrialReader, ABlockIsFoundWhereverItLiesInTheSearchWindow) {
  const std::string whole = CountingTrial(30, 10);
  const std::size_t at = BlockOffsets(whole)[3];
  for (std::size_t length = (1U << 16) - 8; length <= (1U << 16) + 2; ++length) {
    std::string strange = whole;
    strange.insert(at, std::string(length, 'x'));
    const auto read = ReadBytes(strange);
    EXPECT_EQ(read->record.rows, 30) << length;
    EXPECT_EQ(read->report.losses.at(0).bytes, length);
  }
}

TEST(TrialReader, ARepeatedEventIsNotBelievedTwice) {
  MemoryDisk disk;
  ManualClock clock;
  auto writer = WriterInto(&disk, CountsHeader(Timing::kUniform), clock);
  const std::size_t before = disk.bytes.size();
  ASSERT_TRUE(writer.AddEvent({.kind = EventKind::kRemark, .text = "once"}));
  disk.bytes += disk.bytes.substr(before);
  const auto read = ReadBytes(disk.bytes);
  EXPECT_EQ(read->report.events.size(), 1);
  EXPECT_EQ(read->report.losses.at(0).kind, FindingKind::kBlockOutOfOrder);
}

TEST(TrialReader, RowsBehindADamagedBlockKeepTheirTimes) {
  MemoryDisk disk;
  ManualClock clock;
  auto writer = WriterInto(&disk, CountsHeader(Timing::kArrival), clock);
  for (int i = 0; i < 40; ++i) {
    ASSERT_TRUE(AppendCounts(&writer, i, {.time_ns = i * std::int64_t{10'000'000}}));
    if (i % 10 == 9) {
      ASSERT_TRUE(writer.Flush());
    }
  }
  std::string bytes = disk.bytes;
  bytes[BlockOffsets(bytes)[3] + kHead] ^= 1;
  const auto read = ReadBytes(bytes);
  ASSERT_EQ(read->record.rows, 30);
  EXPECT_EQ(read->record.stretches.size(), 2);
  EXPECT_NEAR(TimeOf(read->record, 9), 0.09, 1e-12);
  EXPECT_NEAR(TimeOf(read->record, 10), 0.2, 1e-12);
}

TEST(TrialReader, PolledRowsLieInTheMiddleOfRequestAndReply) {
  MemoryDisk disk;
  ManualClock clock;
  auto writer = WriterInto(&disk, CountsHeader(Timing::kPolled), clock);
  ASSERT_TRUE(AppendCounts(&writer, 1, {.time_ns = 1'000'000, .reply_ns = 5'000'000}));
  ASSERT_TRUE(AppendCounts(&writer, 2, {.time_ns = 11'000'000, .reply_ns = 15'000'000}));
  ASSERT_TRUE(writer.Flush());
  const auto read = ReadBytes(disk.bytes);
  EXPECT_NEAR(read->record.raw_times_s.at(0), 0.003, 1e-15);
  EXPECT_NEAR(read->record.stretches.at(0).rate_hz, 100, 1e-9);
}

TEST(TrialReader, LabelsGivenLaterCountAlsoAfterACut) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.bin");
  const std::string whole = CountingTrial(30, 10);
  for (const std::size_t cut : {whole.size(), whole.size() - 60, whole.size() - 130}) {
    std::ofstream(path, std::ios::binary) << whole.substr(0, cut);
    const auto before = ReadRecord(path);
    ASSERT_TRUE(before);
    for (const char* subject : {"3", "4"}) {
      const auto done =
          AppendEvent(path, {.kind = EventKind::kLabels, .labels = {{"subject", subject}}});
      ASSERT_TRUE(done) << done.error().Text();
    }
    const auto after = ReadRecord(path);
    ASSERT_TRUE(after);
    EXPECT_EQ(after->record.metadata.labels.at("subject"), "4") << cut;
    EXPECT_EQ(after->record.rows, before->record.rows);
    EXPECT_EQ(after->report.closed, before->report.closed);
    EXPECT_EQ(after->report.losses.size(), before->report.losses.size()) << cut;
    EXPECT_EQ(after->report.RowsLost(), before->report.RowsLost());
  }
}

TEST(TrialReader, EventsComeBackInTheirPlace) {
  MemoryDisk disk;
  ManualClock clock;
  auto writer = WriterInto(&disk, CountsHeader(Timing::kArrival), clock);
  ASSERT_TRUE(AppendCounts(&writer, 1, {.time_ns = 1000}));
  ASSERT_TRUE(writer.AddEvent({.kind = EventKind::kReconnect, .time_ns = 5000, .text = "back"}));
  ASSERT_TRUE(AppendCounts(&writer, 2, {.time_ns = 9000}));
  const Stretch stretch{.first_row = 0, .rows = 2, .start_s = 0.125, .rate_hz = 3};
  ASSERT_TRUE(writer.AddEvent({.kind = EventKind::kTimeBase, .stretch = stretch}));
  ASSERT_TRUE(writer.Finish());
  const auto read = ReadBytes(disk.bytes);
  ASSERT_TRUE(read);
  ASSERT_EQ(read->report.events.size(), 2);
  EXPECT_EQ(read->report.events[0].kind, EventKind::kReconnect);
  EXPECT_EQ(read->report.events[0].row, 1);
  EXPECT_EQ(read->report.events[0].time_ns, 5000);
  EXPECT_EQ(read->report.events[0].text, "back");
  // the stored time base counts, the raw times stay beside it
  EXPECT_EQ(TimeOf(read->record, 1), 0.125 + 1.0 / 3);
  EXPECT_EQ(read->record.raw_times_s[1], 9e-6);
}

// four rows 1 ms apart, with these stretches as the recorder's time base; the bit of the byte
// `damaged` is flipped
Recording WithTimeBase(const std::vector<Stretch>& stretches,
                       std::optional<std::size_t> damaged = {}) {
  MemoryDisk disk;
  ManualClock clock;
  auto writer = WriterInto(&disk, CountsHeader(Timing::kArrival), clock);
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(AppendCounts(&writer, i, {.time_ns = i * std::int64_t{1'000'000}}));
  }
  for (const Stretch& stretch : stretches) {
    EXPECT_TRUE(writer.AddEvent({.kind = EventKind::kTimeBase, .stretch = stretch}));
  }
  // one that states nothing
  EXPECT_TRUE(writer.AddEvent({.kind = EventKind::kTimeBase}));
  EXPECT_TRUE(writer.Finish());
  if (damaged) disk.bytes[*damaged] ^= 1;
  auto read = ReadBytes(disk.bytes);
  EXPECT_TRUE(read);
  return std::move(*read);
}

Stretch Part(std::size_t first_row, std::size_t rows, double rate_hz = 7) {
  return {.first_row = first_row, .rows = rows, .start_s = 3, .rate_hz = rate_hz};
}

TEST(TrialReader, AStoredTimeBaseCountsWhereItCoversAllRows) {
  const std::vector<std::vector<Stretch>> whole{
      {Part(0, 4)}, {Part(0, 1), Part(1, 3)}, {Part(0, 3), Part(3, 1)}};
  for (const auto& stretches : whole) {
    const Record record = WithTimeBase(stretches).record;
    ASSERT_EQ(record.stretches.size(), stretches.size());
    EXPECT_EQ(record.stretches.back().first_row, stretches.back().first_row);
    EXPECT_EQ(record.stretches.back().rows, stretches.back().rows);
    EXPECT_EQ(TimeOf(record, 0), 3);
  }
  const std::vector<std::vector<Stretch>> others{{},
                                                 {Part(0, 3)},
                                                 {Part(0, 5)},
                                                 {Part(1, 3)},
                                                 {Part(0, 0), Part(0, 4)},
                                                 {Part(0, 2), Part(1, 2)},
                                                 {Part(0, 2), Part(3, 1)},
                                                 {Part(0, 4, 0)},
                                                 {Part(0, 4, -7)}};
  for (std::size_t k = 0; k < others.size(); ++k) {
    const Record record = WithTimeBase(others[k]).record;
    ASSERT_EQ(record.stretches.size(), 1U) << k;
    EXPECT_NEAR(record.stretches[0].rate_hz, 1000, 1e-9) << k << ": of the times of arrival";
  }
  // nor where a block is lost, though it be the first copy of the header
  const Recording damaged = WithTimeBase({Part(0, 4)}, kSignature.size() + kHead);
  EXPECT_EQ(damaged.report.losses.size(), 1U);
  EXPECT_EQ(damaged.record.rows, 4U);
  EXPECT_NEAR(damaged.record.stretches.at(0).rate_hz, 1000, 1e-9);
}

// 300 lines at 1 kHz; then three are missing, and the 100 behind them are 0.2 ms late. Returns when
// the first of these left the source.
double StartBehind(std::optional<std::uint64_t> missing) {
  MemoryDisk disk;
  ManualClock clock;
  TrialHeader header = CountsHeader(Timing::kArrival);
  header.metadata.fields[std::string(kLineNumbersField)] = "0 to 99";
  auto writer = WriterInto(&disk, header, clock);
  for (int i = 0; i < 400; ++i) {
    if (i == 300) {
      EXPECT_TRUE(writer.AddEvent({.kind = EventKind::kGap, .missing = missing}));
    }
    const std::int64_t late_ns = i < 300 ? 0 : 3'200'000;
    EXPECT_TRUE(AppendCounts(&writer, i, {.time_ns = i * std::int64_t{1'000'000} + late_ns}));
  }
  EXPECT_TRUE(writer.Finish());
  const auto read = ReadBytes(disk.bytes);
  EXPECT_TRUE(read);
  EXPECT_EQ(read->record.stretches.size(), 2U);
  EXPECT_EQ(read->record.stretches.back().first_row, 300U);
  return read->record.stretches.back().start_s;
}

TEST(TrialReader, AKnownNumberOfMissingRowsPutsBothSidesOnOneLine) {
  EXPECT_NEAR(StartBehind(3), 0.303, 1e-9) << "on the line of the first 300";
  EXPECT_NEAR(StartBehind(std::nullopt), 0.3032, 1e-9) << "a line of its own";
  EXPECT_NEAR(StartBehind((std::uint64_t{1} << 40) + 1), 0.3032, 1e-9)
      << "more than any recording has";
}

// 1000 numbered lines at 1 kHz, of which three are missing before line 300 without an event that
// states them; the block of another event may be damaged. The rows of each stretch.
std::vector<std::size_t> RowsOfNumbered(bool has_damage) {
  MemoryDisk disk;
  ManualClock clock;
  TrialHeader header = CountsHeader(Timing::kArrival);
  header.metadata.fields[std::string(kLineNumbersField)] = "0 to 99";
  auto writer = WriterInto(&disk, header, clock);
  std::size_t event_end = 0;
  for (int i = 0; i < 1000; ++i) {
    if (i == 300) {
      EXPECT_TRUE(writer.AddEvent({.kind = EventKind::kRemark, .text = "behind the loss"}));
      event_end = disk.bytes.size();
    }
    EXPECT_TRUE(
        AppendCounts(&writer, i, {.time_ns = (i < 300 ? i : i + 3) * std::int64_t{1'000'000}}));
  }
  EXPECT_TRUE(writer.Finish());
  if (has_damage) disk.bytes[event_end - 2] ^= 1;
  const auto read = ReadBytes(disk.bytes);
  EXPECT_TRUE(read);
  EXPECT_EQ(read->report.losses.size(), has_damage ? 1U : 0U);
  std::vector<std::size_t> rows;
  for (const Stretch& stretch : read->record.stretches) rows.push_back(stretch.rows);
  return rows;
}

// numbers state every loss, unless a block that may have held one is lost itself
TEST(TrialReader, OfNumberedLinesLossesAreLookedForOnlyWhereABlockIsLost) {
  EXPECT_EQ(RowsOfNumbered(false), (std::vector<std::size_t>{1000}));
  EXPECT_EQ(RowsOfNumbered(true), (std::vector<std::size_t>{300, 700}));
}

// 1000 numbered lines at 1 kHz, of which line 300 came twice: a turn less one seems to be lost
TEST(TrialReader, ALossThatTheTimesDoNotHoldIsADoubt) {
  MemoryDisk disk;
  ManualClock clock;
  TrialHeader header = CountsHeader(Timing::kArrival);
  header.metadata.fields[std::string(kLineNumbersField)] = "0 to 999";
  auto writer = WriterInto(&disk, header, clock);
  for (int i = 0; i < 1000; ++i) {
    if (i == 301) {
      EXPECT_TRUE(writer.AddEvent({.kind = EventKind::kGap, .missing = {{999U}}}));
    }
    const std::int64_t place = i > 300 ? i - 1 : i;
    EXPECT_TRUE(AppendCounts(&writer, i, {.time_ns = place * 1'000'000}));
  }
  EXPECT_TRUE(writer.Finish());
  const auto read = ReadBytes(disk.bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(tests::DoubtsOf(read->report.AllFindings()), std::vector{FindingKind::kNumbersRefuted});
  EXPECT_EQ(tests::NumbersOf(read->report.AllFindings(), FindingKind::kNumbersRefuted),
            "lines=1 row=301 missing=999");
  ASSERT_EQ(read->record.stretches.size(), 2U);
  EXPECT_NEAR(read->record.stretches[1].start_s, 0.3, 1e-9);
  EXPECT_NEAR(read->record.stretches[1].rate_hz, 1000, 1e-6);
  EXPECT_EQ(read->report.events.at(0).missing, std::optional(std::optional<std::uint64_t>(999)))
      << "the file holds what was sent";
}

TEST(TrialReader, LaterEventsChangeLabelsAndExclusion) {
  TrialHeader header = CountsHeader(Timing::kUniform);
  header.metadata.labels = {{"subject", "1"}, {"rig", "A"}};
  ReadReport report;
  const auto exclusion = [&] { return ExclusionOf(MetadataOf(header, report)); };
  EXPECT_EQ(exclusion(), std::nullopt);
  report.events = {{.kind = EventKind::kLabels, .labels = {{"subject", "2"}}},
                   {.kind = EventKind::kLabels, .labels = {{"subject", "3"}}},
                   {.kind = EventKind::kExcluded, .text = "loose"}};
  EXPECT_EQ(MetadataOf(header, report).labels,
            (std::map<std::string, std::string>{{"subject", "3"}, {"rig", "A"}}));
  EXPECT_EQ(exclusion(), "loose");
  report.events.push_back({.kind = EventKind::kIncluded, .text = "it was not"});
  EXPECT_EQ(exclusion(), std::nullopt);
  report.events.push_back({.kind = EventKind::kExcluded});
  EXPECT_EQ(exclusion(), "not stated");
}

TEST(TrialReader, ALossIsToldWithItsNumbers) {
  const Loss one{.offset = 100, .bytes = 50, .block = 3, .first_row = 7, .rows = 1};
  EXPECT_EQ(tests::NumbersOf(FindingOfLoss(one)), "block=3 from_byte=100 to_byte=149 row=7");
  Loss loss = one;
  loss.last_block = 5;
  loss.rows = 2;
  EXPECT_EQ(tests::NumbersOf(FindingOfLoss(loss)),
            "first_block=3 last_block=5 from_byte=100 to_byte=149 first_row=7 last_row=8");
  loss.bytes = 0;
  loss.rows = std::nullopt;
  EXPECT_EQ(tests::NumbersOf(FindingOfLoss(loss)), "first_block=3 last_block=5 after_row=7");
  loss.rows = 0;
  EXPECT_EQ(tests::NumbersOf(FindingOfLoss(loss)), "first_block=3 last_block=5");
  ReadReport report;
  EXPECT_EQ(report.RowsLost(), 0U);
  report.losses = {one, one};
  EXPECT_EQ(report.RowsLost(), 2U);
  report.losses.push_back({.rows = std::nullopt});
  EXPECT_EQ(report.RowsLost(), std::nullopt);
}

TEST(ReadReport, IsInterruptedByItsRemarkOrWithoutItsEnd) {
  ReadReport report;
  report.closed = true;
  report.events = {{.kind = EventKind::kRemark, .text = "knocked"}};
  EXPECT_FALSE(report.IsInterrupted());
  EXPECT_FALSE(report.AllFindings().Has(FindingKind::kNotFinished));
  report.events.push_back({.kind = EventKind::kRemark, .text = std::string(kInterruptedText)});
  EXPECT_TRUE(report.IsInterrupted());
  report.events.clear();
  report.closed = false;
  EXPECT_TRUE(report.IsInterrupted());
  EXPECT_TRUE(report.AllFindings().Has(FindingKind::kNotFinished));
}

TEST(ReadReport, ADoubtOfTheSensorIsAFinding) {
  ReadReport report;
  report.closed = true;
  report.events = {{.kind = EventKind::kRemark, .text = "knocked"},
                   {.kind = EventKind::kRemark, .text = "doubt: errors on the wire"}};
  EXPECT_EQ(tests::DoubtsOf(report.AllFindings()), std::vector{FindingKind::kDoubtedAtRecording});
  EXPECT_EQ(tests::NumbersOf(report.AllFindings(), FindingKind::kDoubtedAtRecording),
            "text=errors on the wire");
}

TEST(TrialReader, StreamsInTheMemoryOfOneChunk) {
  const std::string bytes = CountingTrial(100'000, 100'000);
  auto reader = TrialReader::OpenFrom(MakeMemorySource(bytes), "t.bin");
  ASSERT_TRUE(reader);
  std::size_t rows = 0;
  for (;;) {
    const auto chunk = reader->Next();
    ASSERT_TRUE(chunk);
    if (*chunk == nullptr) break;
    EXPECT_EQ((*chunk)->first_row(), rows);
    EXPECT_LE((*chunk)->rows() * 5, 1U << 16);
    rows += (*chunk)->rows();
  }
  EXPECT_EQ(rows, 100'000);
}

std::string ErrorOf(const std::string& bytes) {
  const auto read = ReadBytes(bytes);
  if (read) return "was read";
  EXPECT_EQ(read.error().cause, Cause::kCannotAnswer);
  return read.error().Text();
}

TEST(TrialReader, FilesThatAreNoTrialsAreExplained) {
  const std::string whole = CountingTrial(3, 3);
  std::string newer = whole;
  newer[13] = 2;
  newer[14] = '\xfd';
  EXPECT_EQ(ErrorOf(newer),
            "t.bin: is a trial of format version 2, this program reads 1; update haptometer");
  std::string mangled = whole;
  mangled.erase(9, 1);  // CR LF became LF
  EXPECT_EQ(ErrorOf(mangled),
            "t.bin: was changed on its way here, as a text-mode transfer does; copy it again in "
            "binary mode");
  EXPECT_THAT(ErrorOf(whole.substr(0, 5)), HasSubstr("is cut short within its first bytes"));
  EXPECT_THAT(ErrorOf(whole.substr(0, 40)), HasSubstr("both copies of its header"));
  EXPECT_THAT(ErrorOf("\x01\x02random"), HasSubstr("is not a trial; give a trial.bin"));
}

TEST(SourcesOf, AreStatedOrImportedOrNotKnown) {
  using enum DataSource;
  using Sources = std::vector<DataSource>;
  const auto sources = [](const std::string& source, FileKind kind, bool closed) {
    Metadata metadata;
    metadata.source = source;
    ReadReport report;
    report.kind = kind;
    report.closed = closed;
    return SourcesOf(metadata, report);
  };
  const std::vector<std::pair<std::string, Sources>> stated{
      {"device: serial port /dev/ttyUSB0, 9600 baud 8N1", {kDevice}},
      {"emulated device: virtual terminal /dev/pts/3 (not a hardware port)", {kEmulated}},
      {"virtual terminal /dev/pts/3 (not a hardware port)", {kEmulated}},
      {"simulated: a scene, ideal sensor, start from rest", {kSimulated}},
      {"imported", {kImported}},
      {"piped in: standard input, text", {kImported}},
      {"TCP connection a:64000 (what is behind it is not known)", {}},
      {"replay of b (1).bin (simulated: a test)", {kSimulated}},
      {"replay of c.bin (TCP connection a:1 (what is behind it is not known))", {}},
      {"", {}}};
  for (const auto& [source, expected] : stated) {
    EXPECT_EQ(sources(source, FileKind::kTrial, true), expected) << source;
  }
  EXPECT_EQ(sources("", FileKind::kCsv, true), Sources({kImported}));
  EXPECT_EQ(sources("TCP connection a:64000", FileKind::kCsv, true), Sources()) << "as it states";
  EXPECT_EQ(sources("", FileKind::kHdf5, false), Sources({kImported, kInterrupted}));
  EXPECT_EQ(sources("simulated", FileKind::kHdf5, true), Sources({kSimulated}));
  EXPECT_EQ(sources("simulated", FileKind::kTrial, false), Sources({kSimulated, kInterrupted}));
  EXPECT_EQ(NameOf(kInterrupted), "interrupted");
}

TEST(ReadRecording, TellsTrialAndCsvApartAndRefusesTheRest) {
  const ScratchDirectory directory;
  const std::string path = directory.File("f");
  std::ofstream(path, std::ios::binary) << CountingTrial(30, 10);
  EXPECT_EQ(ReadRecording(path)->record.rows, 30);
  std::ofstream(path, std::ios::binary) << "time_s,voltage_v\n0,1\n0.5,2\n";
  const auto csv = ReadRecording(path);
  ASSERT_TRUE(csv);
  EXPECT_TRUE(csv->report.closed);
  EXPECT_EQ(csv->record.Find(ChannelRole::kVoltage)->values[1], 2);

  auto message = [&](const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
    const auto read = ReadRecording(path);
    EXPECT_FALSE(read);
    EXPECT_EQ(read.error().cause, Cause::kCannotAnswer);
    return read.error().Text();
  };
  EXPECT_THAT(message(std::string("\x7f"
                                  "ELF\x02\x01\x01\0",
                                  8)),
              HasSubstr("is not a trial; give a"));
  EXPECT_THAT(message("Dear Sir,\nthe vibration was strong.\n"),
              HasSubstr("no time column is named in its first line"));
  EXPECT_THAT(message("\xff\xfetime"), HasSubstr("no time column"));
  EXPECT_THAT(message("\x01"), HasSubstr("is not a trial"));
  EXPECT_THAT(message(""), HasSubstr("is empty"));
  EXPECT_THAT(ReadRecording(directory.File("")).error().Text(), HasSubstr("is a directory"));
  EXPECT_THAT(ReadRecording(directory.File("none")).error().Text(), HasSubstr("no such file"));
}

}  // namespace
}  // namespace haptometer::trial
