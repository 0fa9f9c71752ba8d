#include "trial/trial_writer.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <limits>

#include "tests/trial/trial_file.h"
#include "trial/block.h"
#include "trial/trial_reader.h"

namespace haptometer::trial {
namespace {

using ::testing::HasSubstr;

TEST(TrialWriter, WhatIsWrittenIsReadBack) {
  MemoryDisk disk;
  ManualClock clock;
  auto writer = WriterInto(&disk, CountsHeader(Timing::kUniform), clock);
  ASSERT_TRUE(AppendCounts(&writer, -3, {.index = 5}));
  ASSERT_TRUE(AppendCounts(&writer, 7, {.index = 6}, SampleStatus::kRepeated));
  ASSERT_TRUE(AppendCounts(&writer, 99998, {.index = 9}, SampleStatus::kOver));
  const auto totals = writer.Finish();
  ASSERT_TRUE(totals);
  EXPECT_EQ(totals->rows_kept, 3);
  EXPECT_EQ(totals->statuses[static_cast<std::size_t>(SampleStatus::kOver)], 1);

  const auto read = ReadBytes(disk.bytes);
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_TRUE(read->report.closed);
  EXPECT_TRUE(read->report.losses.empty());
  const Channel& channel = read->record.channels.at(0);
  EXPECT_EQ(channel.values[0], -3 * 1e-6 + 0.25);
  EXPECT_EQ(channel.values[1], 7 * 1e-6 + 0.25);
  EXPECT_TRUE(std::isnan(channel.values[2]));
  EXPECT_EQ(channel.statuses[1], SampleStatus::kRepeated);
  EXPECT_EQ(channel.statuses[2], SampleStatus::kOver);
  // two samples are missing on the grid: the time jumps
  ASSERT_EQ(read->record.stretches.size(), 2);
  EXPECT_EQ(TimeOf(read->record, 0), 0.005);
  EXPECT_EQ(TimeOf(read->record, 2), 0.009);
}

TEST(TrialWriter, FloatsComeBackBitForBit) {
  TrialHeader header = CountsHeader(Timing::kUniform);
  header.channels[0].encoding = Encoding::kF32;
  header.channels.push_back(header.channels[0]);
  header.channels[1].encoding = Encoding::kF64;
  MemoryDisk disk;
  ManualClock clock;
  auto writer = WriterInto(&disk, header, clock);
  // a signalling NaN with a payload, which arithmetic would quieten
  const std::array<Sample, 2> row{Sample{RawValue::Bits(0x7fa12345), SampleStatus::kOk},
                                  Sample{RawValue::F64(-0.0), SampleStatus::kOk}};
  ASSERT_TRUE(writer.Append({.index = 0, .samples = row}));
  ASSERT_TRUE(writer.Finish());
  auto reader = TrialReader::OpenFrom(MakeMemorySource(disk.bytes), "t.bin");
  ASSERT_TRUE(reader);
  const auto chunk = reader->Next();
  ASSERT_TRUE(chunk && *chunk != nullptr);
  EXPECT_EQ((*chunk)->At(0, 0).raw.bits(), 0x7fa12345);
  EXPECT_EQ((*chunk)->At(0, 1).raw.bits(), 0x8000000000000000);
}

TEST(TrialWriter, MetadataComesBack) {
  TrialHeader header = CountsHeader(Timing::kArrival);
  Metadata& metadata = header.metadata;
  metadata.source = "device: /dev/ttyUSB0";
  metadata.averages = 16;
  metadata.sampling_s = 1e-3;
  metadata.drive_frequency_hz = 225;
  metadata.tare_m = -0.1;
  metadata.labels = {{"subject", "3"}, {"condition", "stöck \"new\""}};
  metadata.notes = {"one", "two"};
  metadata.command_line = "acquire $'\\377.bin'";  // a file name that is no UTF-8
  header.channels[0].range_max = 0.01;
  MemoryDisk disk;
  ManualClock clock;
  auto writer = WriterInto(&disk, header, clock);
  const auto read = ReadBytes(disk.bytes);
  ASSERT_TRUE(read) << read.error().Text();
  const Metadata& back = read->record.metadata;
  EXPECT_EQ(back.source, metadata.source);
  EXPECT_EQ(back.averages, 16);
  EXPECT_EQ(back.sampling_s, 1e-3);
  EXPECT_EQ(back.drive_frequency_hz, 225);
  EXPECT_EQ(back.drive_amplitude_v, std::nullopt);
  EXPECT_EQ(back.tare_m, -0.1);
  EXPECT_EQ(back.labels, metadata.labels);
  EXPECT_EQ(back.notes, metadata.notes);
  EXPECT_EQ(back.command_line, metadata.command_line);
  EXPECT_EQ(read->record.channels[0].range_max, 0.01);
  EXPECT_EQ(read->record.channels[0].range_min, -std::numeric_limits<double>::infinity());
  EXPECT_FALSE(read->report.closed);
  EXPECT_EQ(read->record.rows, 0);
}

TEST(TrialWriter, FlushesOnceAnIntervalAndNotMore) {
  MemoryDisk disk;
  ManualClock clock;
  auto writer = WriterInto(&disk, CountsHeader(Timing::kUniform), clock);
  EXPECT_EQ(disk.syncs, 1);
  ASSERT_TRUE(AppendCounts(&writer, 1, {.index = 0}));
  clock.Advance(kNsPerS - 1);
  ASSERT_TRUE(AppendCounts(&writer, 1, {.index = 1}));
  EXPECT_EQ(disk.syncs, 1);
  EXPECT_EQ(ReadBytes(disk.bytes)->record.rows, 0);
  clock.Advance(1);
  ASSERT_TRUE(writer.FlushIfDue());
  EXPECT_EQ(disk.syncs, 2);
  EXPECT_EQ(ReadBytes(disk.bytes)->record.rows, 2);
  ASSERT_TRUE(writer.FlushIfDue());
  EXPECT_EQ(disk.syncs, 2);
}

TEST(TrialWriter, ShortWritesChangeNothing) {
  MemoryDisk disk;
  ManualClock clock;
  disk.most_at_once = 7;
  auto writer = WriterInto(&disk, CountsHeader(Timing::kUniform), clock);
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(AppendCounts(&writer, i, {.index = i}));
  ASSERT_TRUE(writer.Finish());
  EXPECT_EQ(disk.bytes, CountingTrial(50, 1000));
}

TEST(TrialWriter, FullDiskSaysWhatIsKeptAndStaysInError) {
  // room for everything but the last 20 bytes of the second block
  MemoryDisk disk;
  ManualClock clock;
  auto writer = WriterInto(&disk, CountsHeader(Timing::kUniform), clock);
  disk.room = disk.bytes.size() + std::size_t{2 * (48 + 500) - 20};
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(AppendCounts(&writer, i, {.index = i}));
  ASSERT_TRUE(writer.Flush());
  for (int i = 100; i < 200; ++i) ASSERT_TRUE(AppendCounts(&writer, i, {.index = i}));
  const auto flushed = writer.Flush();
  ASSERT_FALSE(flushed);
  EXPECT_EQ(flushed.error().cause, Cause::kFailed);
  EXPECT_EQ(flushed.error().Text(),
            "t.bin: could not be written: No space left on device; 100 of 200 rows are kept; make "
            "room and record the rest to another file");
  disk.room = SIZE_MAX;
  // the first error stays
  EXPECT_EQ(AppendCounts(&writer, 1, {.index = 200}).error().what, flushed.error().what);
  EXPECT_EQ(writer.AddEvent({}).error().remedy, flushed.error().remedy);
  EXPECT_EQ(writer.FlushIfDue().error().remedy, flushed.error().remedy);
  EXPECT_EQ(writer.Flush().error().remedy, flushed.error().remedy);
  EXPECT_EQ(writer.Finish().error().remedy, flushed.error().remedy);
  const auto read = ReadBytes(disk.bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->record.rows, 100);
  ASSERT_EQ(read->report.losses.size(), 1);
  const Loss& loss = read->report.losses[0];
  EXPECT_EQ(loss.kind, FindingKind::kEndsInBlock);
  EXPECT_EQ(loss.block, 3U);
  EXPECT_EQ(loss.first_row, 100U);
  EXPECT_EQ(loss.rows, 100U);
}

// of the signature, of either copy of the header
TEST(TrialWriter, WithoutRoomForItsBeginNoneIsMade) {
  const std::size_t whole = CountingTrial(0, 1).size();
  for (const std::size_t room :
       {std::size_t{0}, kSignature.size() - 1, kSignature.size(), whole / 4, whole / 2}) {
    MemoryDisk disk;
    disk.room = room;
    ManualClock clock;
    const auto refused = TrialWriter::CreateIn(std::make_unique<MemorySink>(&disk), "t.bin",
                                               CountsHeader(Timing::kUniform), {}, clock);
    ASSERT_FALSE(refused) << room;
    EXPECT_EQ(refused.error().Text(),
              "t.bin: could not be written: No space left on device; 0 of 0 rows are kept; make "
              "room and record the rest to another file");
  }
}

TEST(TrialWriter, ExistingFilesAreRefusedUnlessReplaced) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.bin");
  std::ofstream(path) << "precious";
  ManualClock clock;
  const auto header = CountsHeader(Timing::kUniform);
  const auto refused = TrialWriter::Create(path, header, {}, clock);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().cause, Cause::kUsage);
  EXPECT_EQ(refused.error().Text(),
            path + ": already exists; name another file, or give <overwrite>");
  EXPECT_EQ(std::filesystem::file_size(path), 8);
  auto replaced = TrialWriter::Create(path, header, {.overwrite = true}, clock);
  ASSERT_TRUE(replaced) << replaced.error().Text();
  // a second writer is kept out, and what the first wrote stays
  const auto second = TrialWriter::Create(path, header, {.overwrite = true}, clock);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().Text(), HasSubstr("is being recorded by another program"));
  EXPECT_FALSE(AppendEvent(path, {.kind = EventKind::kLabels, .labels = {{"a", "b"}}}));
  ASSERT_TRUE(replaced->Finish());
  EXPECT_TRUE(ReadRecord(path)->report.closed);
}

TEST(TrialWriter, AMissingDirectoryIsNamed) {
  ManualClock clock;
  const ScratchDirectory directory;
  const auto refused = TrialWriter::Create(directory.File("missing/t.bin"),
                                           CountsHeader(Timing::kUniform), {}, clock);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().cause, Cause::kFailed);
  EXPECT_THAT(refused.error().Text(), HasSubstr("No such file or directory"));
}

TEST(TrialWriter, KilledProcessLosesNothingThatWasFlushed) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.bin");
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    // 1000 rows flushed, 10 more waiting, then killed in the middle of it
    ManualClock clock;
    auto writer = TrialWriter::Create(path, CountsHeader(Timing::kUniform), {}, clock);
    for (int i = 0; i < 1010; ++i) {
      if (!AppendCounts(&*writer, i, {.index = i})) _exit(1);
      if (i == 999 && !writer->Flush()) _exit(1);
    }
    if (write(ready[1], "x", 1) != 1) _exit(1);
    for (;;) pause();
  }
  close(ready[1]);
  char byte = 0;
  ASSERT_EQ(read(ready[0], &byte, 1), 1);
  close(ready[0]);
  kill(child, SIGKILL);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  const auto recording = ReadRecord(path);
  ASSERT_TRUE(recording) << recording.error().Text();
  EXPECT_EQ(recording->record.rows, 1000);
  EXPECT_FALSE(recording->report.closed);
  // the lock died with the process
  EXPECT_TRUE(AppendEvent(path, {.kind = EventKind::kLabels, .labels = {{"subject", "3"}}}));
  EXPECT_EQ(ReadRecord(path)->record.metadata.labels.at("subject"), "3");
}

// --- others who lay hands on the file while it is written --------------------------------------

// a trial of one channel at `path`, with 300 rows on the disk
TrialWriter BegunAt(const std::string& path, Clock& clock) {
  auto writer = TrialWriter::Create(path, CountsHeader(Timing::kUniform), {}, clock);
  EXPECT_TRUE(writer);
  for (std::int64_t i = 0; i < 300; ++i) EXPECT_TRUE(AppendCounts(&*writer, 1, {.index = i}));
  EXPECT_TRUE(writer->Flush());
  return std::move(*writer);
}

TEST(TrialFile, ThatAnotherCutsIsAnErrorAndNoHole) {
  for (const bool at_the_end : {false, true}) {
    const ScratchDirectory directory;
    const std::string file = directory.File("t.bin");
    ManualClock clock;
    TrialWriter writer = BegunAt(file, clock);
    const auto whole = std::filesystem::file_size(file);
    ASSERT_EQ(truncate(file.c_str(), 700), 0);
    Result<void> done;
    if (at_the_end) {
      const auto totals = writer.Finish();
      if (!totals) done = std::unexpected(totals.error());
    } else {
      ASSERT_TRUE(AppendCounts(&writer, 2, {.index = 300}));
      done = writer.Flush();
    }
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().cause, Cause::kFailed);
    EXPECT_THAT(done.error().what,
                HasSubstr(fmt::format("cut the file from {} to 700 bytes", whole)));
    EXPECT_EQ(std::filesystem::file_size(file), 700) << "nothing is appended to it";
  }
}

TEST(TrialFile, ThatAnotherDeletesOrReplacesIsAnError) {
  for (const bool is_replaced : {false, true}) {
    const ScratchDirectory directory;
    const std::string file = directory.File("t.bin");
    ManualClock clock;
    TrialWriter writer = BegunAt(file, clock);
    if (is_replaced) {
      std::ofstream(file + ".other") << "another's";
      std::filesystem::rename(file + ".other", file);
    } else {
      std::filesystem::remove(file);
    }
    const auto done = writer.Flush();
    ASSERT_FALSE(done);
    EXPECT_THAT(done.error().what, HasSubstr("deleted or replaced"));
    EXPECT_THAT(done.error().remedy, HasSubstr("nothing of it is kept"));
    EXPECT_EQ(std::filesystem::exists(file), is_replaced);
  }
}

TEST(TrialFile, ThatAnotherMovesIsWrittenToTheEndAndItsPlaceIsSaid) {
  const ScratchDirectory directory;
  const std::string file = directory.File("t.bin");
  const std::string other = directory.File("elsewhere.bin");
  ManualClock clock;
  TrialWriter writer = BegunAt(file, clock);
  std::filesystem::rename(file, other);
  ASSERT_TRUE(AppendCounts(&writer, 2, {.index = 300}));
  const auto totals = writer.Finish();
  ASSERT_TRUE(totals);
  EXPECT_TRUE(std::filesystem::equivalent(totals->moved_to, other));
  const auto read = ReadRecord(other);
  ASSERT_TRUE(read);
  EXPECT_TRUE(read->report.closed);
  EXPECT_EQ(read->record.rows, 301);
}

// RLIMIT_FSIZE stands for a full disk: a write takes a part and the next one fails
class FileLimit {
 public:
  explicit FileLimit(std::uintmax_t bytes) {
    EXPECT_EQ(getrlimit(RLIMIT_FSIZE, &before_), 0);
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit tight{.rlim_cur = bytes, .rlim_max = before_.rlim_max};
    EXPECT_EQ(setrlimit(RLIMIT_FSIZE, &tight), 0);
  }
  ~FileLimit() { EXPECT_EQ(setrlimit(RLIMIT_FSIZE, &before_), 0); }
  FileLimit(const FileLimit&) = delete;
  FileLimit& operator=(const FileLimit&) = delete;

 private:
  rlimit before_{};
};

TEST(TrialFile, WithoutRoomForAnEventGivenLaterStaysAsItWas) {
  const ScratchDirectory directory;
  const std::string file = directory.File("t.bin");
  ManualClock clock;
  ASSERT_TRUE(BegunAt(file, clock).Finish());
  const auto whole = std::filesystem::file_size(file);
  const Event event{.kind = EventKind::kLabels, .labels = {{"subject", "3"}}};
  // no byte, a part of the head, a part of the event
  for (const std::uintmax_t room : {0U, 20U, 60U}) {
    Result<void> done;
    {
      const FileLimit tight(whole + room);
      done = AppendEvent(file, event);
    }
    ASSERT_FALSE(done) << room;
    EXPECT_EQ(done.error().cause, Cause::kFailed);
    EXPECT_THAT(done.error().Text(),
                ::testing::StartsWith(file + ": could not be written: File too large; the "
                                             "recording itself is unchanged"));
    EXPECT_EQ(std::filesystem::file_size(file), whole) << room;
  }
  EXPECT_TRUE(AppendEvent(file, event));
  EXPECT_EQ(ReadRecord(file)->record.metadata.labels.at("subject"), "3");
}

TEST(TrialFile, ThatMayNotGrowIsCutBehindItsLastWholeBlock) {
  const ScratchDirectory directory;
  const std::string file = directory.File("t.bin");
  ManualClock clock;
  TrialWriter writer = BegunAt(file, clock);
  const auto whole = std::filesystem::file_size(file);
  for (std::int64_t i = 300; i < 400; ++i) ASSERT_TRUE(AppendCounts(&writer, 1, {.index = i}));
  Result<void> done;
  {
    const FileLimit tight(whole + 100);
    done = writer.Flush();
  }
  ASSERT_FALSE(done);
  EXPECT_THAT(done.error().remedy, HasSubstr("300 of 400 rows are kept"));
  EXPECT_EQ(std::filesystem::file_size(file), whole) << "no part of a block is left";
  const auto read = ReadRecord(file);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->record.rows, 300);
  EXPECT_TRUE(read->report.losses.empty());
}

}  // namespace
}  // namespace haptometer::trial
