// Exports as HDF5, MAT, NPY and WAV, read back: the recording itself is the oracle, bit by bit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "tests/findings.h"
#include "tests/trial/recordings.h"
#include "tests/trial/trial_file.h"
#include "trial/export/export.h"
#include "trial/import/read_recording.h"
#include "trial/import/readers.h"
#include "trial/trial_format.h"

namespace haptometer::trial {
namespace {

using ::testing::HasSubstr;

std::string Say(const Finding& found) { return tests::NumbersOf(found); }

// the export that writes pieces of bytes
Result<void> WriteStream(const std::string& path, const Recording& recording) {
  std::ofstream file(path, std::ios::binary);
  const auto sink = [&](std::string_view bytes) -> Result<void> {
    file << bytes;
    return {};
  };
  if (path.ends_with(".npy")) return WriteNpy(recording, sink, Say);
  HAPTOMETER_TRY(WriteWav(recording, sink, Say));
  return {};
}

// the exports that are made by a library
Result<void> Export(const std::string& path, const Recording& recording) {
  if (path.ends_with(".h5")) {
    HAPTOMETER_LET(auto writer, Hdf5Writer::Create(path));
    HAPTOMETER_TRY(writer.Add("t", recording, nullptr, Say));
    return writer.Close();
  }
  if (!path.ends_with(".mat")) return WriteStream(path, recording);
  HAPTOMETER_LET(auto writer, MatWriter::Create(path));
  HAPTOMETER_TRY(writer.Add("t", recording, Say));
  return writer.Close();
}

// 2000 rows at 8 kHz of two channels: a distance of 30 mm and a voltage about 0
Recording TwoChannels() {
  Recording recording;
  Record& record = recording.record;
  record.rows = 2000;
  record.stretches = {{.rows = 2000, .start_s = 0.25, .rate_hz = 8000}};
  record.channels = {{.name = "OUT1", .role = ChannelRole::kDisplacement, .unit = "m"},
                     {.name = "coil", .role = ChannelRole::kVoltage, .unit = "V"}};
  record.channels[0].range_max = 0.035;
  record.channels[0].resolution = 1e-7;
  for (std::size_t n = 0; n < record.rows; ++n) {
    const double phase = 2 * std::numbers::pi * 225 * static_cast<double>(n) / 8000;
    record.channels[0].values.push_back(0.03 + 1e-4 * std::sin(phase));
    record.channels[1].values.push_back(std::cos(phase) / 3);
    // a status beside ok that is a measurement, of one channel
    record.channels[0].statuses.push_back(n % 3 == 1 ? SampleStatus::kRepeated : SampleStatus::kOk);
    record.channels[1].statuses.push_back(SampleStatus::kOk);
  }
  Metadata& metadata = record.metadata;
  metadata.source = "simulated";
  metadata.averages = 16;
  metadata.sampling_s = 1e-4;
  metadata.drive_frequency_hz = 225;
  metadata.fields = {{"calibration.OUT1.relative_standard_uncertainty", "0.005"}};
  metadata.labels = {{"subject", "\xc3\xa4"}};
  recording.report.closed = true;
  recording.report.events = {
      {.kind = EventKind::kRemark, .row = 2000, .text = "interrupted: \xe2\x88\x9e"}};
  return recording;
}

// lines that arrived in bursts, with a gap where lines were lost
Recording Arrived() {
  MemoryDisk disk;
  ManualClock clock;
  auto writer = WriterInto(&disk, CountsHeader(Timing::kArrival), clock);
  for (int i = 0; i < 3000; ++i) {
    const int n = i < 1500 ? i : i + 700;
    // sent each millisecond, delivered each 16 ms
    const std::int64_t time_ns = (n / 16 + 1) * std::int64_t{16'000'000};
    EXPECT_TRUE(AppendCounts(&writer, n * 37 % 1001, {.time_ns = time_ns}));
  }
  EXPECT_TRUE(writer.Finish());
  auto read = ReadBytes(disk.bytes);
  EXPECT_TRUE(read);
  return std::move(*read);
}

// a recording with times of its own, on no grid
Recording Known() {
  auto record = ParseCsv("time_s,displacement_m\n0,1\n0.25,2\n0.6,3\n0.7,4\n", "f.csv");
  EXPECT_TRUE(record && record->times_are_known);
  Recording recording{.record = *std::move(record), .report = {}};
  recording.report.closed = true;
  return recording;
}

void ExpectRoundTrip(const std::string& path, const Recording& recording) {
  const auto done = Export(path, recording);
  ASSERT_TRUE(done) << done.error().Text();
  const auto back = ReadRecording(path);
  ASSERT_TRUE(back) << back.error().Text();
  ExpectSame(back->record, recording.record);
  EXPECT_EQ(back->record.timing, recording.record.timing);
  EXPECT_EQ(back->record.times_are_known, recording.record.times_are_known);
  EXPECT_TRUE(back->report.is_export);
  EXPECT_EQ(back->report.closed, recording.report.closed);
  EXPECT_EQ(back->report.rows, recording.record.rows);
  ASSERT_EQ(back->report.events.size(), recording.report.events.size());
  for (std::size_t i = 0; i < back->report.events.size(); ++i) {
    EXPECT_EQ(EventToJson(back->report.events[i]), EventToJson(recording.report.events[i]));
  }
  // losses become remarks, one each
  EXPECT_EQ(back->report.findings.list().size(), recording.report.losses.size());
  EXPECT_FALSE(IsTable(path));
}

class Exports : public ::testing::TestWithParam<const char*> {};

TEST_P(Exports, HoldTheLabelsAsRecordedToo) {
  const ScratchDirectory directory;
  const std::string path = directory.File(std::string("t") + GetParam());
  Recording changed = TwoChannels();
  changed.report.first_labels = {{"subject", "1"}};
  changed.report.events = {{.kind = EventKind::kLabels, .labels = {{"subject", "\xc3\xa4"}}}};
  ASSERT_TRUE(Export(path, changed));
  const auto back = ReadRecording(path);
  ASSERT_TRUE(back) << back.error().Text();
  EXPECT_EQ(back->record.metadata.labels, changed.record.metadata.labels);
  ASSERT_EQ(back->report.events.size(), 2U);
  EXPECT_EQ(back->report.events[0].labels, changed.report.first_labels);
  EXPECT_EQ(back->report.events[0].text, "as recorded");
  EXPECT_EQ(back->report.events[1].labels, changed.report.events[0].labels);
}

TEST_P(Exports, AreReadBackBitForBit) {
  const ScratchDirectory directory;
  const std::string path = directory.File(std::string("t") + GetParam());
  ExpectRoundTrip(path, TwoChannels());
  Recording unfinished = TwoChannels();
  unfinished.report.closed = false;
  ExpectRoundTrip(path, unfinished);
}

// a WAV has no place for these
TEST_P(Exports, OfGapsAndTimesOffTheGridAreReadBackOrRefused) {
  const ScratchDirectory directory;
  const std::string path = directory.File(std::string("t") + GetParam());
  const Recording arrived = Arrived();
  ASSERT_EQ(arrived.record.stretches.size(), 2);
  for (const Recording& recording : {arrived, Polled(), Known()}) {
    if (std::string(GetParam()) != ".wav") {
      ExpectRoundTrip(path, recording);
      continue;
    }
    const auto done = Export(path, recording);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().cause, Cause::kCannotAnswer);
  }
}

TEST_P(Exports, OfAnotherSizeThanTheyStateAreRefusedOrHarmless) {
  const ScratchDirectory directory;
  const std::string path = directory.File(std::string("t") + GetParam());
  ASSERT_TRUE(Export(path, TwoChannels()));
  std::ifstream file(path, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(file), {}};
  const std::size_t step = whole.size() / 37;
  for (std::size_t cut = 200; cut + 1 < whole.size(); cut += step) {
    std::ofstream(path, std::ios::binary) << whole.substr(0, cut);
    const auto read = ReadRecording(path);
    // never a part of the trial as if it were the whole
    EXPECT_FALSE(read && read->report.is_export) << cut;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Exports, ::testing::Values(".h5", ".mat", ".npy", ".wav"));

TEST(WavExport, OfAStreamKeepsAllButTheTimesOfArrival) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.wav");
  Recording stream = TwoChannels();
  stream.record.timing = Timing::kArrival;
  stream.record.stretches[0].rate_hz = 8000.2;
  stream.record.stretches[0].time_uncertainty_s = 2e-5;
  for (std::size_t row = 0; row < stream.record.rows; ++row) {
    stream.record.raw_times_s.push_back(TimeOf(stream.record, row) + 1e-4);
  }
  ASSERT_TRUE(Export(path, stream));
  const auto back = ReadRecording(path);
  ASSERT_TRUE(back) << back.error().Text();
  stream.record.raw_times_s.clear();
  ExpectSame(back->record, stream.record);
}

TEST(MatExport, OneOfSeveralIsReadByItsName) {
  const ScratchDirectory directory;
  const std::string path = directory.File("all.mat");
  auto writer = MatWriter::Create(path);
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->Add("a", Polled()));
  ASSERT_TRUE(writer->Add("b", TwoChannels()));
  ASSERT_TRUE(writer->Close());
  EXPECT_EQ(ReadRecording(path).error().Text(),
            path + ": holds 2 trials: a, b; name one as " + path + "/a");
  EXPECT_THAT(ReadRecording(path + "/c").error().Text(), HasSubstr("holds no variable 'c'"));
  const auto b = ReadRecording(path + "/b");
  ASSERT_TRUE(b) << b.error().Text();
  ExpectSame(b->record, TwoChannels().record);
}

}  // namespace
}  // namespace haptometer::trial
